"""Bases of reduced bodies: how they are made, and kept in files."""
