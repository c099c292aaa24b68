"""Search for an order of assembly."""
