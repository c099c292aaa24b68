"""Why a figure of ours differs from the published one, a sentence each."""

from __future__ import annotations

EXPLANATIONS: dict[tuple[str, str], str] = {}
"""By study and column."""
