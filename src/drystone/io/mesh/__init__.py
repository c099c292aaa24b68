"""Mesh formats: OBJ, STL, PLY, GLB."""
