"""From cells on a surface to blocks with planar joints."""
