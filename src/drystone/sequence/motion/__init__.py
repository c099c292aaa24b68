"""Motion of blocks: free directions and rotations at the joints, and paths of removal."""
