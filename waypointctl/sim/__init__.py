"""The physical world: robots and stepping one or many of them."""
