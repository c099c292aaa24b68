"""Conversion of COMPAS objects, and the functions of compas_cra under their own names."""

from drystone.base.settings import hold
from drystone.compat.compas import from_compas as from_compas
from drystone.compat.compas import to_compas as to_compas

__all__ = hold(globals())
