"""Rhino 3dm."""
