"""A limit as a scene: the state on either side of it, and the values that were tried."""

from __future__ import annotations

import html
from dataclasses import replace

import numpy as np

from drystone.answer.asked import UP, Asked
from drystone.answer.scene import Scene, SceneStage
from drystone.answer.widening import side_by_side
from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.limits import Evaluation, Limit, TiltSweep
from drystone.limits.limit_families import Shrunk
from drystone.results import Result, Verdict

WIDTH, HEIGHT = 280.0, 130.0
LEFT, RIGHT, TOP, BOTTOM = 12.0, 12.0, 26.0, 30.0
"""Size [px] of the drawing, and of its margins."""

_MOST_DIGITS = 9
"""Of a value; closer brackets are told alike."""
_NAMED_AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "-x": (-1, 0, 0), "-y": (0, -1, 0)}


def limit_scene(limit: Limit) -> Scene:
    """A scene that compares the last state that stands with the first one that falls.

    If their blocks differ (a limit of thickness), the blocks of the other state are absent.

    Raises
    ------
    InputError
        No state is known on either side.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import tower
    >>> limit = drystone.limit_tilt(tower(3), "y", friction=0.9)
    >>> [stage.headline for stage in limit_scene(limit).stages]
    ['Stands up to 26.5 degrees about y', 'Falls at 26.6 degrees about y']
    """
    best = limit.best
    states = [
        (state, value, falls)
        for state, value, falls in (
            (best.standing, best.stands, False), (best.falling, best.falls, True)
        )
        if state is not None and value is not None
    ]  # fmt: skip
    if not states:
        raise InputError("there is no picture: no state is known on either side of the limit")
    last = states[-1][0]
    model = last.model
    assembly, contacts = model.assembly, model.contacts
    stages = tuple(_stage(limit, *one) for one in states)
    if not all(_same_shape(state, last) for state, _, _ in states):
        names = [" (falls)" if falls else " (stands)" for _, _, falls in states]
        models = [state.model for state, _, _ in states]
        assembly, contacts, stages = side_by_side(models, stages, names)
    facts = Asked.of(model).facts()
    asked = {name: text for name, text in facts.items() if name not in ("Load", "Friction")}
    title = f"drystone: {_summary(limit, last)}"
    panels = (evaluations_panel(limit),)
    return Scene(assembly, contacts, stages, title, asked, panels=panels, still=-1)


def sweep_scene(sweep: TiltSweep) -> Scene:
    """The states on either side of the limit in the lowest known direction, with a plot of all.

    Raises
    ------
    InputError
        No direction is known.
    """
    lowest = sweep.lowest
    scene = limit_scene(sweep.limits[lowest])
    message = f"{sweep.rank} leans towards {sweep.azimuth[lowest]:g} degrees"
    stages = tuple(
        replace(
            one, headline=f"{one.headline}: {sweep.rank}", message=f"{message}; {one.message}"
        )
        for one in scene.stages
    )  # fmt: skip
    return replace(scene, stages=stages, panels=(polar_panel(sweep), *scene.panels))


def _same_shape(first: Result, second: Result) -> bool:
    """Whether two results are of blocks in the same places."""
    one, other = first.assembly, second.assembly
    if one is other or len(one) != len(other):
        return one is other
    return bool(np.array_equal(one.bounds, other.bounds))


def _stage(limit: Limit, state: Result, value: float, falls: bool) -> SceneStage:
    """One side of the limit."""
    told = _quantity_text(limit, value, state)
    headline = f"{'Falls at' if falls else _verb(limit)} {told}"
    facts = state.asked.facts()
    return replace(
        state.stage(f"{'falls' if falls else 'stands'} at {_short(limit, value)}"),
        headline=headline,
        message=_means(limit, state),
        facts={name: text for name, text in facts.items() if name in ("Load", "Friction")},
    )


def _verb(limit: Limit) -> str:
    """The value up to which, or down to which, it stands."""
    return "Stands up to" if limit.end >= limit.start else "Stands down to"


def _summary(limit: Limit, state: Result) -> str:
    stands = limit.best.stands
    if stands is None:
        return "it does not stand anywhere in the range that was searched"
    return f"{_verb(limit).lower()} {_quantity_text(limit, stands, state)}"


def _quantity_text(limit: Limit, value: float, state: Result) -> str:
    """The value of a limit with its unit, and for a tilt its direction.

    Examples
    --------
    See :func:`limit_scene`.
    """
    if limit.parameter == "tilt":
        return f"{_told(limit, value, 3)} degrees{_about(state)}"
    if limit.parameter == Shrunk.parameter:
        return f"{_told(limit, value)} of the {limit.parameter}"
    unit = f" {limit.unit}" if limit.unit else ""
    return f"{_name(limit)} {_told(limit, value)}{unit}"


def _told(limit: Limit, value: float, digits: int = 4) -> str:
    """A value with so many digits, or with as many more as tell both sides of the limit apart."""
    both = [one for one in (limit.best.stands, limit.best.falls) if one is not None]
    while digits < _MOST_DIGITS and len({f"{one:.{digits}g}" for one in both}) < len(both):
        digits += 1
    return f"{value:.{digits}g}"


def _name(limit: Limit) -> str:
    """The parameter as a person writes it."""
    return limit.parameter.replace("_", " ")


def _short(limit: Limit, value: float) -> str:
    mark = "\N{DEGREE SIGN}" if limit.unit == "deg" else f" {limit.unit}" if limit.unit else ""
    return f"{_told(limit, value)}{mark}"


def _about(state: Result) -> str:
    """The axis of the rotation of the model, from the direction of gravity."""
    total = state.load.wrench[~state.assembly.fixed, :3].sum(axis=0)
    axis = np.cross(-total, UP)
    size = float(np.linalg.norm(axis))
    if size < 1e-9 * float(np.linalg.norm(total)):
        return ""
    axis = axis / size
    for name, along in _NAMED_AXES.items():
        if np.allclose(axis, along, atol=1e-6):
            return f" about {name}"
    towards = float(np.rad2deg(np.arctan2(axis[1], axis[0]))) - 90.0
    return f" towards {towards % 360.0:.4g} degrees from x"


def _means(limit: Limit, state: Result) -> str:
    """How the limit was found."""
    parts = [state.message] if state.message else []
    for name, bracket in (
        ("some forces balance the loads", limit.equilibrium),
        ("stands for uniform contact stiffness", limit.uniform),
        ("stands for every contact stiffness tried", limit.robust if limit.remarks else None),
        ("stands", limit.rest),
    ):
        if bracket is not None and bracket.stands is not None:
            parts.append(f"{name} to {_short(limit, bracket.stands)}")
    parts += limit.remarks
    for low, high in limit.islands:
        parts.append(f"it stands again from {_short(limit, low)} to {_short(limit, high)}")
    if limit.stopped:
        parts.append(f"not finished: {limit.stopped}")
    return "; ".join(parts)


def evaluations_panel(limit: Limit) -> str:
    """HTML with the values that were tried: how many contact stiffnesses stand at each."""
    tried = limit.evaluations
    if not tried:
        return ""
    value = np.array([one.value for one in tried])
    best = limit.best
    ends = [end for end in (best.stands, best.falls) if end is not None]
    low, high = min(*ends, *value), max(*ends, *value)
    marks = [
        f'<path d="M{LEFT:g} {TOP:g}V{HEIGHT - BOTTOM:g}H{WIDTH - RIGHT:g}" fill="none"'
        ' stroke="var(--line)"/>'
    ]
    if best.stands is not None:
        at = _across(np.array([best.stands]), low, high)[0]
        marks.append(
            f'<path d="M{at:.1f} {TOP:g}V{HEIGHT - BOTTOM:g}" stroke="var(--ink)"'
            f' stroke-dasharray="3 3"/><text x="{_within(at):.1f}" y="{TOP - 9:g}"'
            f' text-anchor="middle">{html.escape(_short(limit, best.stands))}</text>'
        )
    if best.falls is not None and best.falls not in value:  # shown by equilibrium alone
        marks.append(_cross(_across(np.array([best.falls]), low, high)[0], HEIGHT - BOTTOM))
    for x, one in zip(_across(value, low, high), tried, strict=True):
        y = HEIGHT - BOTTOM - _share(one) * (HEIGHT - TOP - BOTTOM)
        if one.verdict is Verdict.UNSTABLE:
            marks.append(_cross(x, y))
        else:
            fill = "var(--good)" if one.verdict is Verdict.STABLE else "none"
            marks.append(
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{fill}" stroke="var(--good)"/>'
            )
    for end in (low, high):
        at = _across(np.array([end]), low, high)[0]
        marks.append(
            f'<text x="{_within(at):.1f}" y="{HEIGHT - BOTTOM + 13:g}" text-anchor="middle">'
            f"{html.escape(_short(limit, end))}</text>"
        )
    name = html.escape(_name(limit))
    return f"""    <fieldset><legend>Values that were tried</legend>
      <svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="100%" role="img" fill="var(--quiet)"
        font-size="11" aria-label="Share of contact stiffnesses that stand, by {name}">
        {"".join(marks)}
        <text x="{WIDTH / 2:g}" y="{HEIGHT - 3:g}" text-anchor="middle">{name}</text>
      </svg>
      <p>Discs stand, crosses fall; the height is the share of the contact stiffnesses tried that
      stand.</p>
    </fieldset>"""


def _cross(x: float, y: float) -> str:
    path = f"M{x - 3.5:.1f} {y - 3.5:.1f}l7 7m0 -7l-7 7"
    return f'<path d="{path}" stroke="var(--bad)" stroke-width="1.5"/>'


def _share(one: Evaluation) -> float:
    if one.samples.tried:
        return one.samples.standing / one.samples.tried
    return 1.0 if one.verdict in (Verdict.STABLE, Verdict.EQUILIBRIUM_EXISTS) else 0.0


def _across(value: Floats, low: float, high: float) -> Floats:
    share = (value - low) / (high - low) if high > low else np.full(len(value), 0.5)
    place: Floats = LEFT + share * (WIDTH - LEFT - RIGHT)
    return place


def _within(x: float) -> float:
    """A position at which a text is not cut off."""
    return min(max(float(x), 24.0), WIDTH - 24.0)


def polar_panel(sweep: TiltSweep) -> str:
    """HTML with the largest tilt towards each direction, seen from above, x to the right."""
    side, reach = 240.0, 92.0
    rest = np.nan_to_num(sweep.rest)
    most = max(float(np.nanmax(np.nan_to_num(sweep.equilibrium))), float(rest.max()), 1e-9)
    angle = np.deg2rad(sweep.azimuth)

    def ring(values: Floats) -> str:
        radius = reach * np.nan_to_num(values) / most
        x, y = 0.5 * side + radius * np.cos(angle), 0.5 * side - radius * np.sin(angle)
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))

    lowest = sweep.lowest
    mark = ring(rest).split()[lowest].split(",")
    return f"""    <fieldset><legend>Largest tilt towards each direction</legend>
      <svg viewBox="0 0 {side:g} {side:g}" width="100%" role="img" fill="var(--quiet)"
        font-size="11" aria-label="Largest tilt towards each direction">
        <circle cx="{side / 2:g}" cy="{side / 2:g}" r="{reach:g}" fill="none"
          stroke="var(--line)"/>
        <polygon points="{ring(sweep.equilibrium)}" fill="none" stroke="var(--unsure)"
          stroke-dasharray="4 3"/>
        <polygon points="{ring(rest)}" fill="var(--accent)" fill-opacity="0.15"
          stroke="var(--accent)" stroke-width="2"/>
        <circle cx="{mark[0]}" cy="{mark[1]}" r="4" fill="var(--bad)"/>
        <text x="{side - 8:g}" y="{side / 2 + 4:g}" text-anchor="end">x</text>
        <text x="{side / 2:g}" y="14" text-anchor="middle">y</text>
      </svg>
      <p>Blue: stands. Dashed: some forces balance the loads. The circle is {most:.3g} degrees. Red:
      {sweep.rank}, {rest[lowest]:.3g} degrees towards {sweep.azimuth[lowest]:g} degrees.</p>
    </fieldset>"""
