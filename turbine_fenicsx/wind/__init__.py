"""Wind and what it does to blades: polars, blade-element momentum theory, inflow."""
