"""Blocks on contact springs: one law, one tangent, one Newton loop; rest, follow, drive."""
