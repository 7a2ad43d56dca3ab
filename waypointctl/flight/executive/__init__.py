"""The executive on board: commands in, stages and events out."""
