"""Suites of paths and what a policy achieves on them; without torch."""
