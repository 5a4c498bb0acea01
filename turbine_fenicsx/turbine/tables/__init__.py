"""The tables of case files, one file for each: keys, meaning, unit, range, checks."""
