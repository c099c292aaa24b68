"""Shape by gradient: vertices moved until a structure stands, or is least, or reaches farthest."""
