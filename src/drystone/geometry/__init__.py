"""Polygons, polyhedra and frames: pure functions on arrays, numpy (and shapely) only."""
