"""Rigid and flexible bodies, and the couplings between them."""
