"""What a log proves and tells: re-simulation and its verdict, the summary, pictures."""
