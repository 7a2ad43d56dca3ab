"""Mission control for learned waypoint policies."""

__version__ = "0.2.0"
