"""Robots: a robot is a folder with robot.yaml and its MJCF; those that come with waypointctl are folders here."""
