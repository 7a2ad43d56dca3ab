"""The flight as standard viewers show it: messages translated to Foxglove schemas, and a layout to see them in."""
