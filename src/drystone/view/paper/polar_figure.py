"""Tilt limits in every direction as a polar plot, through matplotlib when asked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.base.arrays import Floats
from drystone.view.paper.plot_file import saved_plot
from drystone.view.style.palette import ROLE_COLOUR

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drystone.limits import TiltSweep


@saved_plot
def save_polar(sweep: TiltSweep, title: str) -> Figure:
    """Draw the largest tilt towards every direction, by both definitions."""
    from matplotlib.figure import Figure  # optional work: plotting is slow to import

    colour = ROLE_COLOUR["light"]
    figure = Figure(figsize=(6.0, 6.8))
    axes: Any = figure.add_subplot(projection="polar")
    for values, label, ink, width in (
        (sweep.equilibrium, "some forces balance the loads", colour["missed"], 5.0),
        (sweep.rest, "stands", colour["pressure"], 1.5),
    ):
        ring = _ring(sweep.azimuth, values, closed=not sweep.missing)
        axes.plot(*ring, "-", color=ink, label=label, linewidth=width)
    if sweep.missing:
        known = len(sweep.limits)
        title = f"{title}\n{known} of {known + len(sweep.missing)} directions are known".strip()
    elif np.isfinite(angle := float(sweep.rest[weakest := sweep.weakest])):
        azimuth = float(sweep.azimuth[weakest])
        axes.plot([np.deg2rad(azimuth)], [angle], "D", color=colour["help"], markersize=7)
        title = f"{title}\nweakest towards {azimuth:g} deg: {angle:.2f} deg".strip()
    axes.set_title(title, fontsize=10)
    axes.set_ylim(bottom=0.0)
    axes.set_rlabel_position(67.5)
    axes.set_xlabel("largest tilt [deg] towards each direction, seen from above, x to the right")
    handles = axes.get_legend_handles_labels()
    figure.legend(*handles, loc="lower center", ncol=2, frameon=False, fontsize=9)
    figure.subplots_adjust(bottom=0.16, top=0.84)
    return figure


def _ring(azimuth: Floats, values: Floats, *, closed: bool) -> tuple[Floats, Floats]:
    ring = np.arange(len(azimuth) + closed) % max(len(azimuth), 1)
    return np.deg2rad(azimuth[ring]), values[ring]


__all__ = ["save_polar"]
