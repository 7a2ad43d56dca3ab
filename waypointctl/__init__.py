"""Mission control for learned waypoint policies."""

__version__ = "0.1.0"
