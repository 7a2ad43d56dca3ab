"""What is asked of the robot: the mission and its file."""
