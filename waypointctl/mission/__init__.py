"""The mission and its file."""
