"""What falls, followed with inertia and impacts until it lies: a film, never a verdict."""

from drystone.fall.simulation import FallOptions, Film, fall

__all__ = ["FallOptions", "Film", "fall"]
