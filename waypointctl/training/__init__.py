"""Training on stable-baselines3: recipes, the batched env as a VecEnv, checkpoints, export."""
