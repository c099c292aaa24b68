"""Shells changed until they can be built with less help."""
