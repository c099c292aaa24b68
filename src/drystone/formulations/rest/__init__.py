"""Rest on contact springs: the states that a structure settles into."""
