"""A server on this machine for one model: the live page, and a JSON interface for programs.

``drystone live MODEL`` starts it. It needs nothing but the standard library.
"""

from drystone.live.computing.wish import more_gravity
from drystone.live.serving import serve

__all__ = ["more_gravity", "serve"]
