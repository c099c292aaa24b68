"""Faces from files put in order: points merged, triangles joined, solids told apart."""
