"""Steady states over the wind speed: operating points, equilibria, tables."""
