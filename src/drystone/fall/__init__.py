"""What falls, followed with inertia and impacts until it lies: a film, never a verdict."""

from drystone.fall.film import FallOptions, Film
from drystone.fall.simulation import fall

__all__ = ["FallOptions", "Film", "fall"]
