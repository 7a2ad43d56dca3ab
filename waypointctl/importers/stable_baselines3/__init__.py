"""Models that stable-baselines3 saved, read without executing any of them; no torch."""
