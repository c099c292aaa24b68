"""Analyses as mathematical programs: rigid-block equilibrium and coupled analysis."""
