"""Stiffness, mass and stress of the cross-sections of prisms of any material."""
