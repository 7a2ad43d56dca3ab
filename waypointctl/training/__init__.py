"""Training: recipes, algorithms, checkpoints, selection, export."""

import os

# OpenMP reads it once, when torch is imported. Without it a thread that waits for the others keeps its core, and with
# other programs running a training takes several times as long (bench/threads.py).
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
