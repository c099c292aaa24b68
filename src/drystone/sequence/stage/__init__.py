"""Stages of an assembly: blocks in place, and their checks."""
