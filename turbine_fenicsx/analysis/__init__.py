"""Analyses without time: equilibria, modes, matrices."""
