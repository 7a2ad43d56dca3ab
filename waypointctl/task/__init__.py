"""The task: environment, observation groups, reward terms and courses."""
