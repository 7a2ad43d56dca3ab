"""A flight as a picture: the path, the speed, and the messages between operator and robot."""
