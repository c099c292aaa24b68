"""Other packages' objects in and out, and their functions under their own names."""

from drystone.compat.compas import from_compas, to_compas

__all__ = ["from_compas", "to_compas"]
