"""Scenes of values: the content of a picture before it is drawn."""
