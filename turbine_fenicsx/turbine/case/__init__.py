"""The case file: its tables, units, mistakes, and what it will cost."""
