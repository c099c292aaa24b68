"""What is doubtful about a model before it is checked, and the option that would settle it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.ragged import linked
from drystone.detection.advice import option_for
from drystone.detection.tolerances import Reason
from drystone.io import files_at, format_of
from drystone.io.load_options import TWICE, WEIGHT
from drystone.io.several import Paths
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.stability.asked import CheckOptions
from drystone.stability.verdict import FREELY, check
from drystone.supports import select

_FRICTION = 3.0
"""Chosen: rough stone on stone has at most 1.5."""
_UNIT = re.compile(r"is the unit right \(--(units|density) (\S+)\)\?$")
"""In the remark of a reader on a model of an improbable size or density."""
_MOST = 500
"""Blocks up to which a model is tried on its other side. Chosen: the quick check takes 0.4 s."""
_BEDS = 0.6
"""With more of the area of its joints level, a model lies on its beds. Chosen."""


@dataclass(frozen=True)
class Doubt(OneLine):
    """Something that may not be meant.

    Attributes
    ----------
    text
        A question.
    how
        Arguments of :func:`drystone.read` with which it would be otherwise.
    """

    text: str
    how: Mapping[str, Any]

    @property
    def option(self) -> str:
        """The same on the command line."""
        return " ".join(
            f"--{name} {value:g}" if isinstance(value, float) else f"--{name} {value}"
            for name, value in self.how.items()
        )


def friction_doubts(friction: Any) -> Iterator[Doubt]:
    """That a coefficient is more than any stone has."""
    if isinstance(friction, float | int) and friction > _FRICTION:
        degrees = {"friction": f"{friction:g}deg"}
        yield Doubt(f"friction {friction:g} is more than stone has: are degrees meant?", degrees)


def doubts(model: Model, path: Paths, how: Mapping[str, Any]) -> Iterator[Doubt]:
    """What may not be meant, before anything is solved.

    Only the last kind, of a model that may lie on its side, takes the time of a quick check.

    Parameters
    ----------
    model
    path, how
        What it was read from, and the arguments; see :func:`drystone.read`.
    """
    yield from friction_doubts(how.get("friction"))
    units = unit_doubts(model.notes)
    yield from units
    yield from (Doubt(note, {"case": WEIGHT}) for note in model.notes if note.endswith(TWICE))
    yield from _apart(model)
    if not units and how.get("supports") and (up := other_up(path, how)) and _may_lie(model, how):
        words = _better_upright(model, str(how["supports"]), up)
        if words:
            yield Doubt(f"{words}: does {up} point up in the file?", {"up": up})


def unit_doubts(notes: Iterable[str]) -> list[Doubt]:
    """The remarks of a reader on an improbable size or density."""
    found = [(note, _UNIT.search(note)) for note in notes]
    kinds = {"units": str, "density": float}
    return [Doubt(note, {unit[1]: kinds[unit[1]](unit[2])}) for note, unit in found if unit]


def _apart(model: Model) -> Iterator[Doubt]:
    """Blocks that touch nothing, and that a wider gap would join."""
    report = model.report
    if report is None or not report.isolated:
        return
    alone = set(report.isolated)
    missed = [
        one
        for one in report.missed
        if one.reason is Reason.GAP
        and not one.joined
        and not np.isnan(one.needed)
        and alone & {one.block_a, one.block_b}
    ]
    if missed:
        gap = option_for(max(one.needed for one in missed))
        pairs = {(one.block_a, one.block_b) for one in missed}
        most = max(abs(one.gap) for one in missed)
        yield Doubt(
            f"{counted(len(alone), 'block touches', 'blocks touch')} nothing, and "
            f"{counted(len(pairs), 'pair is', 'pairs are')} up to {1e3 * most:.3g} mm apart: are "
            "they meant to touch?",
            {"gap": f"{gap:g}"},
        )


def other_up(path: Paths, how: Mapping[str, Any]) -> str:
    """The axis that may point up in files in place of the one taken; empty where that is known."""
    if how.get("up") is not None:
        return ""
    taken = {format_of(file).up for file in files_at(path)}
    return {"z": "y", "y": "z"}.get(taken.pop(), "") if len(taken) == 1 else ""


def toward(up: str) -> tuple[float, float, float]:
    """Where the other axis of a file, which may point up, points in its model."""
    return (0.0, 1.0, 0.0) if up == "y" else (0.0, -1.0, 0.0)


def _may_lie(model: Model, how: Mapping[str, Any]) -> bool:
    """Whether it is not all bed joints, under its own gravity, and is looked at soon."""
    if how.get("gravity") is not None or len(model) > _MOST or not model.contacts.count:
        return False
    contacts = model.contacts
    along = contacts.area @ contacts.frame[:, 0] ** 2
    return bool(along[2] < _BEDS * along.sum())


def _feet(assembly: Assembly) -> int:
    """How many groups of supports there are whose boxes are apart."""
    fixed = [assembly.blocks[i].vertices for i in np.flatnonzero(assembly.fixed)]
    low = np.array([one.min(axis=0) for one in fixed])
    high = np.array([one.max(axis=0) for one in fixed])
    apart = 1e-6 * float((high - low).max())
    near = np.all(low[:, None] <= high[None] + apart, axis=2)
    one, other = np.nonzero(near & near.T)
    return int(linked(one, other, len(fixed)).max()) + 1


def _better_upright(model: Model, supports: str, up: str) -> str:
    """How much better it is with another axis up, as text; empty where it is not."""
    axis = toward(up)
    try:
        turned = select(model.assembly, supports, up=axis, joints=model.joints)
    except InputError:
        return ""
    if turned.fixed.all() or _feet(turned) < _feet(model.assembly):
        return ""  # a vault on two feet that falls does stand on its end, as a round wall
    quick = CheckOptions(settle=False)
    lying = check(model, options=quick)
    if lying.stable:
        return ""
    down = LoadCase.gravity(turned, direction=(0.0, -axis[1], 0.0))
    upright = check(replace(model, assembly=turned, load=down), options=quick)
    hangs = [FREELY in one.message for one in (lying, upright)]
    if hangs == [True, False] and not upright.stable:
        return f"as it is nothing presses on the blocks that fall, with {up} up something does"
    return f"it falls as it is, and stands with {up} up" if upright.stable else ""
