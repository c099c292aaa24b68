"""A server on this machine for one model: the live page, and a JSON interface for programs.

``drystone live MODEL`` starts it. It needs nothing but the standard library.
"""

from drystone.live.serving import serve
from drystone.live.wish import more_gravity

__all__ = ["more_gravity", "serve"]
