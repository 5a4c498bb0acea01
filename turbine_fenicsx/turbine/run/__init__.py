"""A case as a run: start, time series, summary, restart."""
