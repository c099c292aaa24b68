"""Plots of what was found: curves, shares, directions and trials, through matplotlib when asked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.base.arrays import Bools, Floats
from drystone.limits.imperfections import share_interval
from drystone.settlement import Drive, End
from drystone.view.paper.plot_file import saved_plot
from drystone.view.style.palette import ROLE_COLOUR

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from drystone.design import Tuned
    from drystone.limits import StandingShare, TiltSweep
    from drystone.sequence import GravityRegion
    from drystone.settlement import LargeDisplacement

LABELS = {
    Drive.LOAD: ("displacement of the load [m]", "load factor"),
    Drive.SUPPORTS: ("motion of the support [m]", "force on the moving supports [N]"),
    Drive.FRICTION: ("largest displacement of a block [m]", "share of the friction"),
}
_INKS = ("pressure", "help", "hinge")
_INCH = 4.2
"""Width of a disc [inches]. Chosen; the dots of all directions just touch."""
_GOAL_UNITS = {"volume": "m3", "height": "m", "reach": "m"}


def _axes(title: str, across: str, up: str) -> tuple[Figure, Any]:
    """A figure with one pair of axes and a grid."""
    from matplotlib.figure import Figure  # optional work: plotting is slow to import

    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    axes: Any = figure.add_subplot(title=title, xlabel=across, ylabel=up)
    axes.title.set_fontsize(10)
    axes.grid(alpha=0.25)
    return figure, axes


@saved_plot
def save_curve(found: LargeDisplacement, title: str) -> Figure:
    """Draw the load against the displacement, with new hinges and slides."""
    colour = ROLE_COLOUR["light"]
    figure, axes = _axes(f"{title}\n{found.message}".strip(), *LABELS[found.drive])
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
    if len(events):
        axes.legend(frameon=False, fontsize=9)
    return figure


@saved_plot
def save_share(found: StandingShare, title: str) -> Figure:
    """Draw the share that stands against the number of draws, with its interval.

    There is a line for each order of loading.
    """
    colour = ROLE_COLOUR["light"]
    figure, axes = _axes(
        title, "draws", f"share that stands, interval at {found.confidence:.0%} confidence"
    )
    table = found.table()
    for row, ink in zip(found.by_loading(), _INKS, strict=False):
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
    axes.set_ylim(-0.02, 1.02)
    axes.legend(frameon=False, fontsize=9, loc="best")
    return figure


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


@saved_plot
def save_gravity(region: GravityRegion, title: str) -> Figure:
    """Draw in which directions of gravity an assembly holds, without and with friction.

    The left disc has the directions that point down, straight down at its centre; the right disc
    those that point up. The projection keeps areas (Lambert).
    """
    from matplotlib.figure import Figure  # optional work: plotting is slow to import

    figure = Figure(figsize=(2.0 * _INCH + 0.6, _INCH + 1.4))
    size = (72.0 * 0.9 * _INCH) ** 2 / max(len(region.direction), 1)
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
        axes.set(xlim=(-1.15, 1.15), ylim=(-1.15, 1.15), aspect="equal")
        axes.set_axis_off()
    figure.suptitle(title, fontsize=11)
    handles = figure.axes[0].get_legend_handles_labels()
    mark = 8.0 / float(np.sqrt(size))  # discs of 8 points, however many directions there are
    figure.legend(*handles, loc="lower center", ncol=2, frameon=False, fontsize=9, markerscale=mark)
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


@saved_plot
def save_front(found: Tuned, title: str) -> Figure:
    """Draw all trials: the first two goals against each other, or one goal by the trial."""
    colour = ROLE_COLOUR["light"]
    several = len(found.goals) > 1
    labels = (
        [_label(goal) for goal in found.goals[:2]] if several else ["trial", _label(found.goals[0])]
    )
    figure, axes = _axes(f"{title}\n{found._summary()}".strip(), *labels)
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
    if drawn:
        axes.legend(frameon=False, fontsize=9)
    return figure


def _place(one: Any, several: bool) -> tuple[float, float]:
    return (one.goals[0], one.goals[1]) if several else (float(one.number), one.goals[0])


def _label(goal: str) -> str:
    name = goal.removeprefix("-")
    unit = f" [{_GOAL_UNITS[name]}]" if name in _GOAL_UNITS else ""
    return f"{name}{unit}, {'most' if goal.startswith('-') else 'least'} is best"
