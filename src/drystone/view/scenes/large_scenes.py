"""Scenes that play a path: large displacement, with its curve in the panel, and films of a fall."""

from __future__ import annotations

import html

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.answer.asked import Asked, directions
from drystone.answer.drawing import interface_layers, state_of
from drystone.answer.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage, State
from drystone.base import units
from drystone.base.arrays import Bools, Floats
from drystone.base.errors import counted
from drystone.checks import block_speed
from drystone.fall import Film
from drystone.settlement import Drive, End, LargeDisplacement, LargeState

WIDTH, HEIGHT = 280.0, 170.0
LEFT, RIGHT, TOP, BOTTOM = 48.0, 8.0, 10.0, 32.0
"""Size [px] of the drawing, and of its margins."""
_SECONDS = 6.0
"""Time in which the page plays the states. Chosen."""
FALLS = 0.1
"""Of the largest motion of a block that falls: those that move more fall with it. Chosen."""
_NO_VERDICT = "a simulated fall: no verdict"
NAMES = {"load": "Push", "supports": "Motion of the supports", "friction": "Loss of friction"}


def large_scene(found: LargeDisplacement) -> Scene:
    """A scene that plays the states from first to last, and the fall where there is one.

    Examples
    --------
    >>> from drystone.models import tower
    >>> from drystone.settlement import push
    >>> scene = large_scene(push(tower(2), friction=0.3, to=0.01))
    >>> scene.stages[0].motion_name, scene.stages[0].headline
    ('Push', 'Push: at most 0.3; followed to 0.01 m, where it is 0.3')
    """
    assembly, contacts, model = found.assembly, found.contacts, found.model
    state = state_of(assembly)
    up, gravity = directions(assembly, model.load)
    name = NAMES[found.drive.value]
    moves = found.drive is Drive.SUPPORTS
    headline = moved_headline(found) if moves else f"{name}: {found.message}"
    last = found.states[-1]
    seen = (*found.states, *([] if found.fallen is None else [found.fallen]))
    path = np.stack([one.positions for one in seen])
    state[blocks_that_fall(found)] = State.FALLING
    message = "; ".join([found.message, *model.notes])
    whole = SceneStage(
        "all states", headline, message, state, motion=path[-1], motion_name=name,
        path=path if len(path) > 1 else None, seconds=_SECONDS, plays=True, up=up, gravity=gravity,
        layers=(*interface_layers(contacts), *_marks(found, last)),
    )  # fmt: skip
    facts = Asked.of(model).facts()
    title = f"drystone: {headline[0].lower()}{headline[1:]}"
    return Scene(
        assembly, contacts, (whole,), title, facts, panels=(_curve_panel(found),), preset="solid"
    )


def blocks_that_fall(found: LargeDisplacement) -> Bools:
    """Which blocks (n,) fall at the end."""
    falls = ~found.assembly.fixed
    if found.fallen is None:
        return falls & False
    gone = block_speed(found.assembly, found.fallen.positions - found.states[-1].positions)
    return falls & (gone > FALLS * float(gone.max()))


def moved_headline(found: LargeDisplacement) -> str:
    """Whether blocks stand with their supports moved, in words for a person.

    Examples
    --------
    >>> from drystone.models import tower
    >>> from drystone.settlement import move_supports
    >>> moved_headline(move_supports(tower(2), {0: (0.0, 0.0, -0.1)}))
    'Stands with its supports moved by 100 mm'
    """
    last = found.states[-1]
    far = units.quantity(float(found.displacement[-1]), "m")
    if found.end is End.FALLS:
        return f"Falls when the supports have moved by {far}"
    if found.end is not End.REACHED:
        return f"Not decided: followed until the supports had moved by {far}"
    marks = [(len(last.hinges), "hinge"), (len(last.sliding), "sliding joint")]
    told = " and ".join(counted(count, what) for count, what in marks if count)
    return f"Stands with its supports moved by {far}{': ' if told else ''}{told}"


def _marks(found: LargeDisplacement, state: LargeState) -> tuple[Layer, ...]:
    """Hinges and sliding joints of a state; they are where their second blocks carry them."""
    made = []
    for key, label, colour, shape, joints in (
        ("hinges", "hinge: presses on one edge", "hinge", MarkerShape.DISC, state.hinges),
        ("sliding", "friction is spent", "help", MarkerShape.DIAMOND, state.sliding),
    ):
        number = np.array(joints, dtype=np.intp)
        if len(number):
            block = state.contacts.block_b[number]
            moved, turn = np.split(state.positions[block], 2, axis=1)
            centroid = found.assembly.centroid[block]
            arm = state.resultants.position[number] - centroid - moved
            place = centroid + Rotation.from_rotvec(turn).inv().apply(arm)
            made.append(
                Layer(key, label, LayerKind.MARKERS, colour, place, block=block, shape=shape)
            )
    return tuple(made)


def _curve_panel(found: LargeDisplacement) -> str:
    """HTML with the curve of load against displacement."""
    far = max(float(found.displacement.max(initial=0.0)), 1e-300)
    low, high = min(float(found.load.min()), 0.0), max(float(found.load.max()), 1e-300)
    x = LEFT + found.displacement / far * (WIDTH - LEFT - RIGHT)
    y = _up(found.load, low, high)
    line = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    base = float(_up(np.zeros(1), low, high)[0])
    unit = found.unit
    top = units.quantity(high, unit) if unit else f"{high:.3g}"
    ticks = [
        (LEFT - 5.0, TOP + 4.0, "end", top),
        (LEFT - 5.0, base + 4.0, "end", "0"),
        (LEFT, HEIGHT - BOTTOM + 14.0, "middle", "0"),
        (WIDTH - RIGHT, HEIGHT - BOTTOM + 14.0, "end", units.quantity(far, "m")),
    ]
    texts = "".join(
        f'<text x="{a:.1f}" y="{b:.1f}" text-anchor="{anchor}">{html.escape(text)}</text>'
        for a, b, anchor, text in ticks
    )
    return f"""    <fieldset><legend>Load against displacement</legend>
      <svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="100%" role="img" fill="var(--quiet)"
        font-size="11" aria-label="Load against displacement">
        <path d="M{LEFT:g} {TOP:g}V{HEIGHT - BOTTOM:g}M{LEFT:g} {base:.1f}H{WIDTH - RIGHT:g}"
          fill="none" stroke="var(--line)"/>
        <polyline fill="none" stroke="var(--accent)" stroke-width="2" points="{line}"/>
        {texts}
      </svg>
      <p>{html.escape(found.message)}</p>
    </fieldset>"""


def _up(load: Floats, low: float, high: float) -> Floats:
    """Place of loads on the axis [px]."""
    place: Floats = HEIGHT - BOTTOM - (load - low) / (high - low) * (HEIGHT - TOP - BOTTOM)
    return place


def film_scene(film: Film) -> Scene:
    """A scene that plays a film in real time."""
    assembly, model = film.assembly, film.model
    state = state_of(assembly)
    state[film.fell] = State.FALLING
    _, gravity = directions(assembly, model.load)
    up = -gravity  # across the ground on which they fall
    headline = film.message[0].upper() + film.message[1:]
    message = "; ".join([_NO_VERDICT, film.engine, *model.notes])
    stage = SceneStage(
        "film", headline, message, state, motion=film.positions[-1], motion_name="Film",
        path=film.positions if len(film) > 1 else None, seconds=float(film.time[-1]), plays=True,
        up=up, gravity=gravity,
    )  # fmt: skip
    facts = Asked.of(model).facts()
    title = f"drystone: {film.message}"
    return Scene(assembly, film.contacts, (stage,), title, facts, preset="solid")
