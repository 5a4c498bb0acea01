"""Load sets: design load cases of IEC 61400-1 as runs of one turbine, and their results."""
