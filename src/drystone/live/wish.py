"""What a window asks for, the model that it makes of the one in the file, and the picture it gets.

The Python lines, and the load case of our JSON, that give what a window shows.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from drystone.answer.question import Question
from drystone.answer.scene import stage_among
from drystone.base import units
from drystone.base.arrays import Floats, Ints, marked
from drystone.base.errors import InputError
from drystone.base.settings import Options, checked_call
from drystone.contacts import Contacts, joined_contacts
from drystone.design.changed_model import acceleration_of
from drystone.geometry.frames import rotation_about
from drystone.io.jsontext import Field
from drystone.limits import Tilt
from drystone.loads import DOWN, LoadCase
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.view import Scene, SceneStage
from drystone.view.encode import encode_stage

_Pulled: TypeAlias = tuple[str, tuple[float, float, float]]
"""Name of a block, and a force or a translation."""


@dataclass(frozen=True)
class Wish(Options):
    """A load case of the live page.

    Attributes
    ----------
    tilt : [degrees] >= 0, <= 180
    direction : [degrees]
        Where the tilted model leans to, from x towards y.
    friction : >= 0
        Coefficient of all joints; ``None`` for those of the model.
    gravity : [m/s2] >= 0, <= 1000
        ``None`` for that of the model. The most is a hundred times that of the earth.
    supports
        Names of the fixed blocks; ``None`` for those of the model.
    removed
        Names of blocks that are taken out.
    pushes
        Names of blocks and forces (3,) [N] at their centroids, which keep their direction in space.
    moves
        Names of supports and their translations (3,) [m], in axes that tilt with the model.
    """

    tilt: float = 0.0
    direction: float = 0.0
    friction: float | None = None
    gravity: float | None = None
    supports: tuple[str, ...] | None = None
    removed: tuple[str, ...] = ()
    pushes: tuple[_Pulled, ...] = ()
    moves: tuple[_Pulled, ...] = ()

    @classmethod
    def read(cls, field: Field) -> Wish:
        """The wish in an object of JSON.

        Raises
        ------
        InputError
            A value that cannot be, with its place.
        """
        field.object().only(tuple(cls.__dataclass_fields__))

        def number(key: str) -> float | None:
            return field[key].number() if field.has(key) else None

        def names(key: str) -> tuple[str, ...]:
            return tuple(one.text() for one in field[key].elements()) if field.has(key) else ()

        def pulled(key: str, what: str) -> tuple[_Pulled, ...]:
            found = []
            for one in field[key].elements() if field.has(key) else ():
                one.object().only(("block", what))
                x, y, z = one[what].floats(3).tolist()
                found.append((one["block"].text(), (x, y, z)))
            return tuple(found)

        return cls(
            number("tilt") or 0.0,
            number("direction") or 0.0,
            number("friction"),
            number("gravity"),
            names("supports") if field.has("supports") else None,
            names("removed"),
            pulled("pushes", "force"),
            tuple(one for one in pulled("moves", "by") if any(one[1])),
        )

    @property
    def axis(self) -> tuple[float, float, float]:
        """Horizontal axis (3,) about which the tilt turns."""
        angle = math.radians(self.direction)
        return -math.sin(angle), math.cos(angle), 0.0


@dataclass(frozen=True, eq=False)
class WishedModel:
    """The model of a wish.

    Attributes
    ----------
    whole
        All blocks of the file's model, with supports, friction and load of the wish.
    part
        The same without the blocks that are taken out.
    upright
        The part before it is tilted.
    kept : (s,)
        Positions of the blocks of the part in the whole.
    axis : (3,)
    motion : (s, 6) [m, rad]
        Of the supports of the part, with that in the load of the file; None where none moves.
    """

    whole: Model
    part: Model
    upright: Model
    kept: Ints
    axis: Floats
    motion: Floats | None = None

    @property
    def moving(self) -> Model:
        """The part, with the motion of its supports in the load."""
        return self.part.with_load(replace(self.part.load, motion=self.motion))


def asked(model: Model, wish: Wish) -> WishedModel:
    """The model that a wish makes of a model.

    Raises
    ------
    InputError
        It names a block that is not there, pushes a fixed one, moves a free one or one that is
        taken out, or takes all blocks out.
    """
    if wish.supports is not None:
        model = model.with_supports(wish.supports)
    if wish.friction is not None:
        model = model.with_friction(wish.friction)
    motion = np.zeros((len(model), 6)) if model.load.motion is None else model.load.motion.copy()
    load = replace(model.load, motion=None)
    if wish.gravity is not None:
        load = load + more_gravity(model, wish.gravity)
    for block, force in wish.pushes:
        load = load + LoadCase.point_load(model.assembly, block, force)
    model = model.with_load(replace(load, name=_load_name(model.load, wish)))
    gone = marked(model.assembly.indices(list(wish.removed)), len(model))
    if gone.all():
        raise InputError("every block is removed", remedy="put one back")
    kept = np.flatnonzero(~gone)
    for i in model.assembly.indices([block for block, _ in wish.moves]):
        if gone[i] or not model.assembly.fixed[i]:
            raise InputError(
                f"block '{model.assembly.names[i]}' is no support, so it cannot be moved",
                remedy="make it a support, or push it",
            )
    for block, by in wish.moves:
        motion[model.assembly.index(block), :3] += by
    motion = motion[kept] * model.assembly.fixed[kept, None]
    moves = motion if motion.any() else None
    axis = np.array(wish.axis)
    whole = Tilt(model, axis)(wish.tilt) if wish.tilt else model
    if not gone.any():
        return WishedModel(whole, whole, model, kept, axis, moves)
    return WishedModel(whole, whole.subset(kept), model.subset(kept), kept, axis, moves)


def _load_name(load: LoadCase, wish: Wish) -> str:
    """What a wish asks about, for the head of the page."""
    words = [load.name]
    if wish.gravity is not None:
        size = f"gravity {wish.gravity:g} m/s\N{SUPERSCRIPT TWO}"
        words = [size] if load.name == "gravity" else [load.name, size]
    pushed = [(block, math.hypot(*force)) for block, force in wish.pushes]
    if len(pushed) == 1:
        words.append(f"{pushed[0][0]} pushed with {units.quantity(pushed[0][1], 'N')}")
    elif pushed:
        words.append(f"{len(pushed)} blocks pushed, at most with "
                     f"{units.quantity(max(size for _, size in pushed), 'N')}")  # fmt: skip
    if len(wish.moves) == 1 and load.motion is None:
        block, by = wish.moves[0]
        words.append(f"{block} moved by {units.quantity(math.hypot(*by), 'm')}")
    elif wish.moves or load.motion is not None:
        words.append("supports moved")
    return ", ".join(words)


@checked_call
def more_gravity(model: Model, gravity: float) -> LoadCase:
    """What is to be added to the load of a model so that gravity has another size [m/s2].

    Parameters
    ----------
    model
        With the load as it is.
    gravity : [m/s2]
        The size that is wanted.
    """
    acceleration = acceleration_of(model)
    size = float(np.linalg.norm(acceleration))
    down = DOWN if size == 0.0 else acceleration
    return LoadCase.gravity(model.assembly, gravity - size, down)


def python_lines(
    source: str, how: Mapping[str, Any], sent: Mapping[str, Any], facts: Mapping[str, Any]
) -> dict[str, Any]:
    """Lines that read a file and give the verdict of a wish, and the wish as a load case.

    Parameters
    ----------
    source
        Name of the file.
    how
        Arguments of :func:`drystone.read` that differ from the default.
    sent
        The wish, as plain values.
    facts
        Of the model: its gravity [m/s2], and whether its load moves supports.
    """
    from pathlib import Path

    wish = Wish.read(Field(dict(sent), "", Path("wish")))
    lines = _lines(source, how, wish, bool(facts["moves"]))
    return {"python": "\n".join(lines) + "\n", "case": _case(wish, facts["gravity"])}


def _lines(source: str, how: Mapping[str, Any], wish: Wish, moves: bool) -> list[str]:
    plain = {key: getattr(one, "value", one) for key, one in how.items() if one is not None}
    given = "".join(f", {key}={one!r}" for key, one in plain.items())
    loads, lines = [], [f"model = drystone.read({source!r}{given})"]
    if wish.supports is not None:
        lines.append(f"model = model.with_supports({list(wish.supports)!r})")
    if wish.friction is not None:
        lines.append(f"model = model.with_friction({wish.friction!r})")
    if wish.gravity is not None:
        loads.append(f"more_gravity(model, {wish.gravity!r})")
    for block, force in wish.pushes:
        numbers = ", ".join(f"{x:.6g}" for x in force)
        loads.append(f"drystone.LoadCase.point_load(model.assembly, {block!r}, ({numbers}))")
    for load in loads:
        lines.append(f"model = model.with_load(model.load + {load})")
    if wish.tilt:
        axis = ", ".join(f"{x + 0.0:.12g}" for x in wish.axis)
        lines.append(f"model = Tilt(model, ({axis}))({wish.tilt!r})  # degrees")
    if wish.removed:
        lines.append(f"model = model.without({list(wish.removed)!r})")
    answer = "drystone.check(model)"
    if wish.moves or moves:
        motion = {block: tuple(float(f"{x:.6g}") for x in by) for block, by in wish.moves}
        answer = f"move_supports(model, {motion!r})"
    imports = ["import drystone"]
    if wish.tilt:
        imports.append("from drystone.limits import Tilt")
    if wish.gravity is not None:
        imports.append("from drystone.live import more_gravity")
    if wish.moves or moves:
        imports.append("from drystone.settlement import move_supports")
    return [*imports, "", *lines, f"print({answer})"]


def _case(wish: Wish, own: float) -> dict[str, Any]:
    """A load case of our JSON: gravity and pushes as the tilted model feels them."""
    turn = rotation_about(np.array(wish.axis), wish.tilt)
    gravity = own if wish.gravity is None else wish.gravity
    parts: list[dict[str, Any]] = [
        {"kind": "gravity", "g": gravity, "direction": _rounded(np.array(DOWN) @ turn)}
    ]
    for block, force in wish.pushes:
        parts.append({"kind": "point", "block": block, "force": _rounded(np.array(force) @ turn)})
    for block, by in wish.moves:
        parts.append({"kind": "settlement", "block": block, "motion": _rounded(np.array(by))})
    return {"name": f"tilt {wish.tilt:g} deg" if wish.tilt else "live", "parts": parts}


def _rounded(values: Any) -> list[float]:
    return [float(f"{x:.12g}") + 0.0 for x in values]


QUICK = {
    Verdict.STABLE: "Stands with uniform stiffness of the joints; others are being tried",
    Verdict.UNDECIDED: "Not at rest with uniform stiffness of the joints; it is being checked",
}
"""Headlines while the whole verdict is not known."""


@dataclass(frozen=True, eq=False)
class Found:
    """An answer and its picture, of the blocks that are in place.

    Attributes
    ----------
    result
    stage
    moved
        Whether the forces of the stage are those at the end of its motion.
    """

    result: Result
    stage: SceneStage
    moved: bool = False

    @classmethod
    def at_rest(cls, result: Result, *, quick: bool = False) -> Found:
        """The picture of a result; ``quick`` where the whole verdict is still to come."""
        stage = result.stage("live")
        if quick:
            stage = replace(stage, headline=QUICK[result.verdict], role=None)
        return cls(result, stage)


def snapshot(asked: WishedModel, wish: Wish, found: Found) -> dict[str, Any]:
    """An answer about ``asked.part``, encoded for the page that shows all blocks of ``asked``.

    Parameters
    ----------
    asked
    wish
    found
    """
    stage, contacts = widened(found, asked)
    turn = rotation_about(asked.axis, wish.tilt)
    part = asked.part
    facts = Question.of(part).facts()
    stage = replace(stage, up=turn[2], gravity=np.array(DOWN) @ turn, facts=facts)
    more = contacts.count > asked.whole.contacts.count
    encoded = encode_stage(Scene(asked.whole.assembly, contacts, (stage,)), contacts=more)
    encoded["stage"]["moved"] = found.moved
    return encoded


def widened(found: Found, asked: WishedModel) -> tuple[SceneStage, Contacts]:
    """A stage of the blocks in place as one of all blocks, and their contacts.

    Blocks taken out are absent. Edges and corners that touch as well come after the contacts of
    the model.
    """
    blocks, contacts = len(asked.whole), asked.whole.contacts
    here = marked(asked.kept, blocks)
    interface = np.flatnonzero(here[contacts.block_a] & here[contacts.block_b])
    own = found.result.model.contacts
    more = own.select(np.arange(own.count) >= len(interface), asked.kept)
    interface = np.append(interface, contacts.count + np.arange(more.count))
    contacts = joined_contacts(contacts, more)
    return stage_among(found.stage, blocks, contacts, asked.kept, interface), contacts
