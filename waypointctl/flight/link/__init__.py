"""The link between operator and robot: discrete events in simulation time, each direction for itself."""
