"""The share of imperfect structures that stand as a plot, through matplotlib when asked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.limits import StandingShare
from drystone.limits.imperfections import share_interval
from drystone.view.paper.plot_file import saved_plot
from drystone.view.style.palette import ROLE_COLOUR

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INKS = ("pressure", "help", "hinge")


@saved_plot
def save_share(found: StandingShare, title: str) -> Figure:
    """Draw the share that stands against the number of draws, with its interval.

    There is a line for each order of loading.
    """
    from matplotlib.figure import Figure  # optional work: plotting is slow to import

    colour = ROLE_COLOUR["light"]
    figure = Figure(figsize=(7.0, 4.4), layout="constrained")
    axes: Any = figure.add_subplot()
    table = found.table()
    for row, ink in zip(found.by_loading(), INKS, strict=False):
        stands = np.cumsum(table["stands"][table["loading"] == row["loading"]])
        count = np.arange(1, len(stands) + 1)
        bounds = np.array(
            [
                share_interval(int(k), int(n), found.confidence)
                for k, n in zip(stands, count, strict=True)
            ]
        ).reshape(-1, 2)
        label = f"{row['loading']}: {row['share']:.1%} ({row['low']:.1%} to {row['high']:.1%})"
        axes.plot(count, stands / count, "-", color=colour[ink], label=label)
        axes.fill_between(count, *bounds.T, color=colour[ink], alpha=0.15, linewidth=0.0)
    axes.set_xlabel("draws")
    axes.set_ylabel(f"share that stands, interval at {found.confidence:.0%} confidence")
    axes.set_ylim(-0.02, 1.02)
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, fontsize=9, loc="best")
    return figure


__all__ = ["save_share"]
