"""Polygons, polyhedra, frames and the repair of faces: pure functions on arrays.

Frames and boxes; plane polygons with their areas, overlaps, triangles and sections; closed
polyhedra with their edges, mass, cuts, shared volume and contacts with themselves; faces from
files with their points merged, triangles joined and solids separated.
"""
