"""Plane joints made wedges where tension appears, until a structure stands."""
