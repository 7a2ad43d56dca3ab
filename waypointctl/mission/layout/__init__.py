"""How a mission file is laid out: one form for one content, comments and units as they were written."""
