"""Joints on curved surfaces as many planar interfaces."""
