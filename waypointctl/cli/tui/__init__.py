"""What people see of a flight: the live view, plain lines, the summary."""
