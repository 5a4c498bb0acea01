"""Studies: one case with many changes, run in parallel; one table, orders of convergence."""
