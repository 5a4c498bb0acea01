"""Modes of a turbine: names, tables, files."""
