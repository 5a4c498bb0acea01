"""The model: what parts make up a system, and its equations."""
