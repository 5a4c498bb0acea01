"""One step in time."""
