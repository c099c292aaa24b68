"""Load against displacement as a plot, through matplotlib when asked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.settlement import Drive, End, LargeDisplacement
from drystone.view.paper.plot_file import saved_plot
from drystone.view.style.palette import ROLE_COLOUR

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LABELS = {
    Drive.LOAD: ("displacement of the load [m]", "load factor"),
    Drive.SUPPORTS: ("motion of the support [m]", "force on the moving supports [N]"),
    Drive.FRICTION: ("largest displacement of a block [m]", "share of the friction"),
}


@saved_plot
def save_curve(found: LargeDisplacement, title: str) -> Figure:
    """Draw the load against the displacement, with new hinges and slides."""
    from matplotlib.figure import Figure  # optional work: plotting is slow to import

    colour = ROLE_COLOUR["light"]
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    axes: Any = figure.add_subplot()
    axes.plot(found.displacement, found.load, "-", color=colour["pressure"], linewidth=1.8)
    events = found.events()
    for kind, label, ink, shape in (
        ("hinge", "a joint becomes a hinge", colour["hinge"], "o"),
        ("slides", "a joint slides", colour["help"], "D"),
    ):
        here = np.flatnonzero(events["event"] == kind)
        if len(here):
            at = events["displacement"][here], events["load"][here]
            axes.plot(*at, shape, color=ink, label=label, markersize=6)
    if found.capacity is not None and found.end is not End.LOST:
        axes.axvline(found.capacity, color=colour["edge"], linestyle=":", linewidth=1.2)
        axes.annotate(
            f"{found.capacity:.4g} m", (found.capacity, axes.get_ylim()[1]), fontsize=9,
            ha="right", va="top", rotation=90, xytext=(-2, -4), textcoords="offset points",
        )  # fmt: skip
    across, up = LABELS[found.drive]
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_title(f"{title}\n{found.message}".strip(), fontsize=10)
    axes.grid(alpha=0.25)
    if len(events):
        axes.legend(frameon=False, fontsize=9)
    return figure


__all__ = ["save_curve"]
