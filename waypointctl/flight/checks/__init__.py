"""Static checks: what may go wrong in a mission, found without flying it."""
