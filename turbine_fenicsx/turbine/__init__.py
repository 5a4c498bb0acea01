"""The wind turbine: parameters, builders, surfaces."""
