"""Structures of the literature, from their published dimensions."""
