"""How long work tells how far it is: one callback, rendered by the command line."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[str, int, int], None]
"""Called as ``progress(stage, done, total)`` with 0 <= done <= total; it must not raise.
Nothing is stopped through it: that is what ``stop`` is for."""
