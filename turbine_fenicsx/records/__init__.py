"""Files that a run leaves behind: names of columns, folders, time series, fields."""
