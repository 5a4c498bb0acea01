"""What needs the model and a linear solver, but no time."""
