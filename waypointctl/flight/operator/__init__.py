"""The ground: who decides what is sent, and what becomes of it until the robot has answered."""
