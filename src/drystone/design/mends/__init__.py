"""Changes that make a structure stand, each one checked."""
