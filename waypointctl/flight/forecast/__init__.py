"""What a mission comes to, worked out without flying it: how long it takes, and what may go wrong."""
