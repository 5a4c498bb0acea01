"""The life of the plies of a turbine: damage of runs, summed over the life."""
