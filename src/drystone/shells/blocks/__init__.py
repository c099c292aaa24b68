"""Cells on a surface converted to blocks with planar joints."""
