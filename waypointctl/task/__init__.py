"""What a policy sees and is paid for."""
