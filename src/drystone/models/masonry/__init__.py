"""Arches, domes, vaults and walls."""
