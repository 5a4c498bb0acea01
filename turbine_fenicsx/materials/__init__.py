"""Hyperelastic materials as UFL strain energies, and damping, one file each."""
