"""The trials of a search for parameters as a plot, with the front of several goals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.design import Tuned
from drystone.view.paper.plot_file import saved_plot
from drystone.view.style.palette import ROLE_COLOUR

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNITS = {"volume": "m3", "height": "m", "reach": "m"}


@saved_plot
def save_front(found: Tuned, title: str) -> Figure:
    """Draw all trials: the first two goals against each other, or one goal by the trial."""
    from matplotlib.figure import Figure  # optional work: plotting is slow to import

    colour = ROLE_COLOUR["light"]
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    axes: Any = figure.add_subplot()
    several = len(found.goals) > 1
    drawn = [one for one in found.trials if one.goals]
    places = {
        stands: np.array([_place(one, several) for one in drawn if one.stands is stands])
        for stands in (True, False)
    }
    for stands, label, ink, shape in (
        (False, "not good enough", colour["edge"], "x"),
        (True, "stands", colour["pressure"], "o"),
    ):
        if len(places[stands]):
            axes.plot(*places[stands].T, shape, color=ink, label=label, markersize=5, alpha=0.6)
    front = np.array([_place(one, several) for one in found.front])
    if len(front):
        label = "front: no other is better in every goal" if several else "best"
        axes.plot(*front.T, "-D", color=colour["help"], label=label, markersize=6, linewidth=1.2)
    axes.set_xlabel(_label(found.goals[0]) if several else "trial")
    axes.set_ylabel(_label(found.goals[1] if several else found.goals[0]))
    axes.set_title(f"{title}\n{found._summary()}".strip(), fontsize=10)
    axes.grid(alpha=0.25)
    if drawn:
        axes.legend(frameon=False, fontsize=9)
    return figure


def _place(one: Any, several: bool) -> tuple[float, float]:
    return (one.goals[0], one.goals[1]) if several else (float(one.number), one.goals[0])


def _label(goal: str) -> str:
    name = goal.removeprefix("-")
    unit = f" [{UNITS[name]}]" if name in UNITS else ""
    return f"{name}{unit}, {'most' if goal.startswith('-') else 'least'} is best"


__all__ = ["save_front"]
