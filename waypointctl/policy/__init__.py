"""Policy bundles: manifest, weights, load, act."""
