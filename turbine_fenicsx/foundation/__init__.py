"""Numbers, files and processes: what knows nothing of mechanics."""
