"""The command line: the only part of drystone that prints."""

from drystone.cli.application import main

__all__ = ["main"]
