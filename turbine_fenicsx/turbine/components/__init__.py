"""Components of a turbine, each with its parts, columns and pictures."""
