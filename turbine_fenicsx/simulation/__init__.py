"""The time loop, observers and checkpoints."""
