"""The directions of gravity in which an assembly holds, as two discs, through matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.view.paper.plot_file import saved_plot
from drystone.view.style.palette import ROLE_COLOUR

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drystone.sequence import GravityRegion

INCH = 4.2
"""Width of a disc [inches]. Chosen; the dots of all directions just touch."""


@saved_plot
def save_gravity(region: GravityRegion, title: str) -> Figure:
    """Draw in which directions of gravity an assembly holds, without and with friction.

    The left disc has the directions that point down, straight down at its centre; the right disc
    those that point up. The projection keeps areas (Lambert).
    """
    from matplotlib.figure import Figure  # optional work: plotting is slow to import

    figure = Figure(figsize=(2.0 * INCH + 0.6, INCH + 1.4))
    size = (72.0 * 0.9 * INCH) ** 2 / max(len(region.direction), 1)
    for place, (name, sign) in enumerate((("down", -1.0), ("up", 1.0)), 1):
        axes: Any = figure.add_subplot(1, 2, place)
        half = sign * region.direction[:, 2] >= 0.0
        for label, mask, ink, filled in _kinds(region):
            spot = _lambert(region.direction[half & mask], sign)
            face = ink if filled else "none"
            axes.scatter(
                spot[:, 0], spot[:, 1], s=size, facecolors=face, edgecolors=ink, label=label
            )
        turn = np.linspace(0.0, 2.0 * np.pi, 181)
        axes.plot(np.cos(turn), np.sin(turn), "-", color=ROLE_COLOUR["light"]["edge"], linewidth=1)
        axes.set_title(f"gravity pointing {name}", fontsize=10)
        axes.set_aspect("equal")
        axes.set_axis_off()
    figure.suptitle(title, fontsize=11)
    handles = figure.axes[0].get_legend_handles_labels()
    figure.legend(*handles, loc="lower center", ncol=2, frameon=False, fontsize=9, markerscale=0.6)
    figure.text(0.5, 0.16, "seen from above, x to the right", ha="center", fontsize=8)
    figure.subplots_adjust(left=0.02, right=0.98, bottom=0.2, top=0.86, wspace=0.02)
    return figure


def _kinds(region: GravityRegion) -> list[tuple[str, Bools, str, bool]]:
    """Kinds of directions: label, mask, colour, whether it is filled."""
    colour = ROLE_COLOUR["light"]
    smooth, rough = region.frictionless, region.balanced
    kinds = [("holds without friction", smooth, colour["pressure"], True)]
    if region.stands is None:
        kinds.append(("forces with friction balance", rough & ~smooth, colour["resultant"], True))
    else:
        stands = region.stands
        kinds += [
            ("stands with friction", rough & stands & ~smooth, colour["resultant"], True),
            (
                "only shims or prestress might hold it",
                rough & ~stands & ~smooth,
                colour["missed"],
                True,
            ),
        ]
    return [*kinds, ("falls", ~rough, colour["help"], False)]


def _lambert(direction: Floats, sign: float) -> Floats:
    """Positions (g, 2) in a unit disc of directions of one half of the sphere."""
    away = 1.0 - sign * direction[:, 2]
    across = np.linalg.norm(direction[:, :2], axis=1)
    radius = np.sqrt(np.maximum(away, 0.0))
    factor = radius / np.where(across > 0.0, across, 1.0)
    out: Floats = direction[:, :2] * factor[:, None]
    return out


__all__ = ["save_gravity"]
