"""The steps by which blocks are followed."""
