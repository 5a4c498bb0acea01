"""Blades of a case: shape, mesh, material, places about the hub."""
