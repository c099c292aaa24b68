"""Plane polygons: areas, overlaps, triangles, sections."""
