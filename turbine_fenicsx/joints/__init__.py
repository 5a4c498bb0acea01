"""Joints between rigid bodies, one file each."""
