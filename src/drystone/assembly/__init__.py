"""Blocks, and which of them are fixed."""

from drystone.assembly.assembly import Assembly as Assembly
from drystone.assembly.assembly import Blocks as Blocks
from drystone.assembly.block import DEFAULT_DENSITY as DEFAULT_DENSITY
from drystone.assembly.block import Block as Block
from drystone.assembly.block import replace_block as replace_block
from drystone.base.settings import hold

__all__ = hold(globals())
