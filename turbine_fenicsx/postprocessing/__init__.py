"""An output folder, read back: plots, pictures, report."""
