"""Blocks, and which of them are fixed."""

from drystone.assembly.assembly import Assembly, Blocks
from drystone.assembly.block import DEFAULT_DENSITY, Block, replace_block
from drystone.base.settings import hold

__all__ = ["DEFAULT_DENSITY", "Assembly", "Block", "Blocks", "replace_block"]

hold(globals())
