"""Conversion of COMPAS objects, and the functions of compas_cra under their own names."""

from drystone.compat.compas import from_compas, to_compas

__all__ = ["from_compas", "to_compas"]
