"""Number of pairs of blocks in contact by the gap tolerance: a curve for the panel of a page."""

from __future__ import annotations

import html

import numpy as np

from drystone.base.arrays import Floats
from drystone.detection import GapSweep

WIDTH, HEIGHT = 280.0, 150.0
LEFT, RIGHT, TOP, BOTTOM = 44.0, 8.0, 10.0, 30.0
"""Size [px] of the drawing, and of its margins."""


def sweep_panel(sweep: GapSweep, used: float) -> str:
    """HTML with the curve, its plateau shaded, and a line at the gap that was ``used``.

    Examples
    --------
    >>> from drystone.detection import gap_sweep
    >>> from drystone.models import tower
    >>> "<svg" in sweep_panel(gap_sweep(tower(3), [1e-5, 1e-3]), 0.005)
    True
    """
    low, high = sweep.plateau
    most = max(int(sweep.pairs.max()), 1)
    x, y = _across(sweep.gap, sweep.gap), _up(sweep.pairs / most)
    band = _across(np.array([low, high]), sweep.gap)
    marks = [
        f'<rect x="{band[0]:.1f}" y="{TOP:g}" width="{max(band[1] - band[0], 2.0):.1f}"'
        f' height="{HEIGHT - TOP - BOTTOM:g}" fill="var(--accent)" opacity="0.18"/>',
        '<polyline fill="none" stroke="var(--accent)" stroke-width="2" points="'
        + " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
        + '"/>',
        f'<path d="M{LEFT:g} {TOP:g}V{HEIGHT - BOTTOM:g}H{WIDTH - RIGHT:g}" fill="none"'
        ' stroke="var(--line)"/>',
    ]
    if sweep.gap[0] <= used <= sweep.gap[-1]:
        at = float(_across(np.array([used]), sweep.gap)[0])
        marks.append(
            f'<path d="M{at:.1f} {TOP:g}V{HEIGHT - BOTTOM:g}" stroke="var(--ink)"'
            ' stroke-dasharray="3 3"/>'
        )
    marks += _ticks(sweep, most)
    told = html.escape(sweep.summary()[-1])
    return f"""    <fieldset><legend>Gap tolerance</legend>
      <svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="100%" role="img" fill="var(--quiet)"
        font-size="11" aria-label="Pairs of blocks that touch, by gap tolerance">
        {"".join(marks)}
      </svg>
      <p>{told}. Dashed: {used:g}, the one used here.</p>
    </fieldset>"""


def _across(gap: Floats, range_of: Floats) -> Floats:
    """Place of gaps on the logarithmic axis [px]."""
    first, last = np.log(range_of[0]), np.log(range_of[-1])
    share = (np.log(gap) - first) / (last - first) if last > first else np.full(len(gap), 0.5)
    place: Floats = LEFT + share * (WIDTH - LEFT - RIGHT)
    return place


def _up(share: Floats) -> Floats:
    """Place of shares of the largest number on the other axis [px]."""
    place: Floats = HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)
    return place


def _ticks(sweep: GapSweep, most: int) -> list[str]:
    ticks = []
    for count in (0, most):
        height = float(_up(np.array([count / most]))[0]) + 4.0
        ticks.append(f'<text x="{LEFT - 5:g}" y="{height:.1f}" text-anchor="end">{count:,}</text>')
    exponents = np.arange(np.ceil(np.log10(sweep.gap[0]) - 1e-9), np.log10(sweep.gap[-1]) + 1e-9)
    step = max(-(-len(exponents) // 4), 1)
    for exponent in exponents[::step].tolist():
        at = float(_across(np.array([10.0**exponent]), sweep.gap)[0])
        ticks.append(
            f'<text x="{at:.1f}" y="{HEIGHT - BOTTOM + 13:g}" text-anchor="middle">'
            f"{10.0**exponent:g}</text>"
        )
    ticks.append(
        f'<text x="{(LEFT + WIDTH - RIGHT) / 2:g}" y="{HEIGHT - 3:g}" text-anchor="middle">'
        "gap by block size: pairs that touch</text>"
    )
    return ticks


__all__ = ["sweep_panel"]
