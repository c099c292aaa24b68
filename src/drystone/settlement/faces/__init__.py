"""The faces of blocks where they touch or may meet: corners, edges, ends."""
