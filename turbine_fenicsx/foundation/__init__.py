"""Numbers, files and processes; no mechanics."""
