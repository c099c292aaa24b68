"""Parametric model families, used by docs, tests and benchmarks."""

from drystone.models.simple import box, tower

__all__ = ["box", "tower"]
