"""Lengths and names as text in a contact report."""

from __future__ import annotations

from collections.abc import Sequence

SHOWN = 8
"""Names listed in one line."""


def listed(items: Sequence[str]) -> str:
    """The first of several names, and the number of others."""
    more = f" and {len(items) - SHOWN} more" if len(items) > SHOWN else ""
    return ", ".join(items[:SHOWN]) + more


def millimetres(length: float) -> str:
    """A length [m] in millimetres, to three digits or a nanometre, and never as a power of ten.

    Examples
    --------
    >>> millimetres(0.0), millimetres(0.0012345), millimetres(-12.345)
    ('0', '1.23', '-12,345')
    """
    value = round(1e3 * float(length), 6) + 0.0
    return f"{value:,.0f}" if abs(value) >= 1e3 else f"{value:.3g}"


__all__ = ["SHOWN", "listed", "millimetres"]
