"""Closed polyhedra: topology, mass properties, cuts, and how they touch each other."""
