"""Flying: the link, commands, the operator on the ground, the executive on board, and the loop."""
