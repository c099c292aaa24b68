"""Large displacement: what drives the blocks, the states, and the analyses."""
