"""Closed polyhedra: topology, mass properties, cuts, shared volume, self-contact."""
