"""The directions of gravity in which an assembly holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from drystone.answer import Answer, Role, Scene, Sentence, Verdict
from drystone.answer.chart import Chart, MarkKind, Marks
from drystone.answer.drawing import bare_scene
from drystone.base.arrays import Bools, Floats, frozen_floats
from drystone.base.declared import Offered
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, checked_call
from drystone.base.table import Table
from drystone.io.opening import Given, LongHow, as_model
from drystone.loads import LoadCase
from drystone.loads.applied import applied_loads
from drystone.model import Model
from drystone.programs import RBEOptions, solve_rbe
from drystone.stability import check


@dataclass(frozen=True, eq=False)
class GravityRegion(Answer):
    """The directions of gravity in which an assembly stands.

    Attributes
    ----------
    model
    direction : (g, 3) unit
        Directions of gravity.
    frictionless : (g,)
        Whether there are contact forces in equilibrium without friction.
    balanced : (g,)
        Whether there are contact forces in equilibrium with the friction of the model.
    stands : (g,) or None
        Whether the verdict of :func:`drystone.check` is STABLE; None if not requested.
    """

    model: Model
    direction: Floats
    frictionless: Bools
    balanced: Bools
    stands: Bools | None = None

    @property
    def shares(self) -> dict[str, float]:
        """Share of the directions for each of the three questions."""
        out = {
            "frictionless": float(self.frictionless.mean()),
            "balanced": float(self.balanced.mean()),
        }
        return out if self.stands is None else out | {"stands": float(self.stands.mean())}

    @property
    def from_down(self) -> Floats:
        """Angle (g,) [degrees] of each direction from straight down."""
        cosine: Floats = np.clip(-self.direction[:, 2], -1.0, 1.0)
        return np.rad2deg(np.arccos(cosine))

    @property
    def title(self) -> str:
        """In which share of the directions it holds."""
        share = 100.0 * self.shares.get("stands", self.shares["balanced"])
        word = "Forces balance" if self.stands is None else "Stands"
        return f"{word} in {share:.3g} % of {counted(len(self.direction), 'direction')} of gravity"

    def sentences(self) -> Sequence[Sentence]:
        """The shares of the directions."""
        good = bool((self.balanced if self.stands is None else self.stands).all())
        smooth = f"without friction in {100.0 * self.shares['frictionless']:.3g} %"
        return [Sentence(self.title, Role.GOOD if good else Role.BAD), Sentence(smooth)]

    def tables(self) -> Sequence[Table]:
        """The directions, straight down first."""
        x, y, z = self.direction.T
        columns = {
            "x": x, "y": y, "z": z, "from_down": self.from_down,
            "frictionless": self.frictionless, "balanced": self.balanced,
        }  # fmt: skip
        if self.stands is not None:
            columns["stands"] = self.stands
        order = np.argsort(self.from_down, kind="stable")
        rows = {name: column[order] for name, column in columns.items()}
        return [Table("directions of gravity", rows, {"from_down": "deg"})]

    def layers(self) -> Scene:
        """The model, and its directions beside it."""
        scene = bare_scene(self.model)
        stage = replace(scene.stages[0], headline=self.title)
        return replace(scene, title=self.title, stages=(stage,), charts=(self.figure(),))

    def figure(self) -> Chart:
        """The directions: straight down in the middle, straight up at the rim."""
        smooth, rough = self.frictionless, self.balanced
        kinds = [("holds without friction", smooth, MarkKind.DISC, "good")]
        if self.stands is None:
            told = "forces with friction balance"
            kinds.append((told, rough & ~smooth, MarkKind.DISC, "accent"))
        else:
            stands = self.stands & ~smooth
            told = "only shims or prestress might hold it"
            kinds.append(("stands with friction", stands, MarkKind.DISC, "accent"))
            kinds.append((told, rough & ~self.stands & ~smooth, MarkKind.DISC, "unsure"))
        kinds.append(("falls", ~rough, MarkKind.RING, "bad"))
        azimuth = np.rad2deg(np.arctan2(self.direction[:, 1], self.direction[:, 0]))
        marks = [
            Marks(kind, azimuth[mask], self.from_down[mask], ink, label)
            for label, mask, kind, ink in kinds
            if mask.any()
        ]
        return Chart(
            "Directions of gravity", tuple(marks), "direction, seen from above, x to the right",
            "angle from straight down", ("deg", "deg"), self.title, polar=True, top=180.0,
        )  # fmt: skip

    def numbers(self) -> Mapping[str, Any]:
        """The shares."""
        return {"shares": self.shares}


@checked_call
def gravity_region(
    given: Given,
    key: int | str | Sequence[int | str] | None = None,
    *,
    directions: int | Floats = 200,
    stands: bool = False,
    **how: Unpack[LongHow],
) -> GravityRegion:
    """The directions of gravity in which an assembly holds, without and with friction.

    Ended early, the result has the first directions, at least one.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    key
        The block or blocks that are held; the supports of the model when left out.
    directions : >= 1
        Number of directions, evenly spread over the sphere. In Python also directions (g, 3).
    stands
        Whether to compute the full verdict too. It takes longer.

    Raises
    ------
    InputError
        No block is held, or there are loads beside the weights, which turn with gravity.

    Examples
    --------
    >>> from drystone.models import tower
    >>> down = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.5, 0.0, -1.0]])
    >>> found = gravity_region(tower(2), directions=down, friction=0.6)
    >>> found.frictionless.tolist(), found.balanced.tolist()
    ([True, False, False], [True, False, True])
    """
    clock = Clock.of(how)
    model = as_model(given, **how)
    if key is not None:
        model = model.with_supports([key] if isinstance(key, int | str) else list(key))
        if not model.assembly.fixed.any():
            raise InputError(
                "no block is held", where="key", remedy="name a block, or leave it out"
            )
    beside = applied_loads(model.assembly, model.load).block
    if len(beside):
        raise InputError(
            f"'{model.assembly.names[beside[0]]}' has a load beside its weight",
            remedy="leave the loads out: only the weights turn with gravity",
        )
    unit = _unit_directions(directions)
    jobs = [(model, tuple(one), stands) for one in unit.tolist()]
    found = list(clock.answers(_held, jobs, "directions", least=1))
    table = np.array(found, dtype=bool).reshape(-1, 3)
    unit = unit[: len(found)]
    return GravityRegion(model, unit, table[:, 0], table[:, 1], table[:, 2] if stands else None)


def _unit_directions(directions: int | Floats) -> Floats:
    """Unit directions (g, 3): so many, or those given."""
    if isinstance(directions, int):
        return _spread(directions)
    given = frozen_floats(np.atleast_2d(directions), (None, 3), "directions")
    length = np.linalg.norm(given, axis=1, keepdims=True)
    if not (len(length) and np.isfinite(length).all() and (length > 0.0).all()):
        raise InputError("a direction is zero or not finite", where="directions")
    return given / length


def _held(job: tuple[Model, tuple[float, float, float], bool]) -> tuple[bool, bool, bool]:
    model, direction, full = job
    pull = LoadCase.gravity(model.assembly, 9.81, direction=direction)
    loaded = model.with_load(pull)
    smooth = _balances(loaded.with_friction(0.0))
    rough = smooth or _balances(loaded)
    return smooth, rough, full and rough and check(loaded).stable


def _balances(model: Model) -> bool:
    found = solve_rbe(model, options=RBEOptions.feasibility())
    return found.verdict is Verdict.EQUILIBRIUM_EXISTS


def _spread(count: int) -> Floats:
    """Directions (count, 3) spread evenly over the sphere: a spiral of equal areas."""
    step = np.arange(count) + 0.5
    height = 1.0 - 2.0 * step / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * step
    across = np.sqrt(1.0 - height**2)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), height])


OFFERED = Offered(
    gravity_region,
    "arch.json --directions 40",
    ("directions", "stands"),
    names=("directions", "stands", "executor", "time_limit_s"),
)
