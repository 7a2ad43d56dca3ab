"""Many flights at once: what a link's delay costs, by how much is decided on board."""
