"""Repair of faces from files: merged points, joined triangles, separated solids."""
