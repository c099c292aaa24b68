"""Locks of cached properties, freed in a process that was forked while a thread held one.

Before Python 3.12 each cached property has a lock. Where a process is forked while a thread holds
it, it stays locked in the fork by a thread that is not there: who asks next waits for ever.
"""

from __future__ import annotations

import os
import sys
from functools import cached_property
from threading import RLock

_PACKAGE = __name__.partition(".")[0]


def free_in_forks() -> None:
    """Free the locks in every process that is forked from now on."""
    if sys.version_info < (3, 12) and hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=_free)


def _free() -> None:
    modules = [one for name, one in list(sys.modules.items()) if name.startswith(_PACKAGE)]
    for kind in {each for one in modules for each in vars(one).values() if isinstance(each, type)}:
        for member in list(vars(kind).values()):
            if isinstance(member, cached_property):
                member.lock = RLock()  # type: ignore[attr-defined]


__all__ = ["free_in_forks"]
