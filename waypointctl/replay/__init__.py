"""Replay of a log: re-simulation with a verdict, summary, pictures."""
