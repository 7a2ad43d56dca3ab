"""Other tools' files as missions: QGroundControl, waypoint files, GeoJSON, GPX, KML, CSV."""
