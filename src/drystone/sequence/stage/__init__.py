"""Stages of an assembly: what is in place, and whether that stands."""
