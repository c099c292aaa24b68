"""Results of following blocks by steps."""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from drystone.answer import Answer, Role, Scene, SceneStage, Sentence, State
from drystone.answer.drawing import enlargement, interface_layers, load_layers, state_of
from drystone.answer.question import directions
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.base.table import Table
from drystone.checks import Residuals, block_speed, check_forces
from drystone.contacts import Contacts
from drystone.geometry.frames import rotation_about, rotations
from drystone.loads.applied import arms_of_loads
from drystone.loads.placing import turned_points, turned_wrench
from drystone.mechanics.bodies import Bodies, turned_load
from drystone.mechanics.corners import Carrier
from drystone.model import Model


def moved_model(model: Model, motion: Floats, axes: Floats, point: Floats) -> Model:
    """The blocks at the end, with each corner as a separate interface; loads act where they did.

    Parameters
    ----------
    model
        Before the motion.
    motion : (n, 6) [m, rad]
    axes : (k, 3, 3), rows n, u, v
    point : (k, 3) [m]
        Each corner.
    """
    assembly, contacts = model.assembly, model.contacts
    joint = contacts.interface
    corners = Contacts(
        contacts.block_a[joint],
        contacts.block_b[joint],
        axes,
        contacts.tributary,
        contacts.friction[joint],
        point,
        np.arange(len(joint)),
    )
    arms = arms_of_loads(assembly, model.load)
    turn, given = rotations(motion[:, 3:]), model.load.given
    wrench = turned_load(model.load.wrench, arms, turn)
    if given is not None:
        given = turned_points(given, np.swapaxes(turn, 1, 2))
    load = replace(model.load, wrench=wrench, given=given, each=())
    return Model(assembly.moved(motion), corners, load, ends=model.ends)


PARTS = 20
"""Of a load that is put on part by part. Chosen: ten models that were measured have the same limit
with the load at once."""


class Loading(enum.Enum):
    """How the load is put on; friction remembers it."""

    AT_ONCE = "at once"
    """All of it in one step."""
    RAMP = "ramp"
    """All of it grows from nothing, in 20 parts with a rest after each."""
    TURNED = "turned"
    """All of it is turned from upright to its direction, in 20 parts with a rest after each."""


def earlier_loads(bodies: Bodies, loading: Loading) -> list[Bodies]:
    """The bodies under the loads under which they rest before the whole load is on."""
    shares = np.arange(PARTS) / PARTS
    if loading is Loading.RAMP:
        return [replace(bodies, load=x * bodies.load, arms=x * bodies.arms) for x in shares[1:]]
    total = bodies.load[:, :3].sum(axis=0)
    size = float(np.linalg.norm(total))
    if loading is Loading.AT_ONCE or size == 0.0:
        return []
    down = np.array([0.0, 0.0, -1.0])
    angle = float(np.rad2deg(np.arccos(np.clip(total @ down / size, -1.0, 1.0))))
    if angle < 1e-9:
        return []
    axis = np.cross(down, total)
    if np.linalg.norm(axis) < 1e-9 * size:
        axis = np.array([1.0, 0.0, 0.0])
    made = []
    for share in shares:
        turn = rotation_about(axis, (share - 1.0) * angle)
        load = turned_wrench(bodies.load, turn.T)
        made.append(replace(bodies, load=load, arms=turn @ bodies.arms @ turn.T))
    return made


class Outcome(enum.Enum):
    """How a settlement ends."""

    RESTS = "comes to rest"
    """Near its first position; with forces that balance the loads on the moved blocks."""
    DISPLACED = "comes to rest far away"
    """At rest, but a block moved by more than in a structure that stands."""
    FALLS = "falls"
    """A block moved by a large share of its size and still moves."""
    ENDS_DECIDE = "the ends of the joints decide"
    """The result depends on the block that carries the ends of the joints."""
    SHEAR_DECIDES = "the shear stiffness of the joints decides"
    """The result depends on their tangential stiffness by the normal one."""
    UNKNOWN = "not followed to an end"
    """The message has the reason."""


UNDECIDED = (Outcome.ENDS_DECIDE, Outcome.SHEAR_DECIDES)
"""Outcomes of paths that end otherwise."""

MOST_STATES, MOST_POSITIONS = 60, 100_000
"""Frames of a path in pictures. Chosen: it looks smooth, and adds 3 MB to a page."""


@dataclass(frozen=True)
class SettlementOptions(Options):
    """Options of :func:`settle`.

    Lengths are relative to the size of a block, the cube root of its volume.

    Attributes
    ----------
    rest_within : > 0, < inf
        Largest displacement of a block with which a structure at rest stands.
    fall : > 0, < inf
        Displacement from which on a moving block falls.
    carrier
        The block that carries the ends of joints where both end flush; the face of the other one
        is taken as longer. ``moving`` is what published programs do. With ``exact`` neither is
        longer, as by faces that are clipped after every step; with ``longer`` those are as well
        that go on by less than what stands may move. When left out, what the model says
        of its ``ends``, or both blocks are followed as carriers if there are such ends.
    overlap : >= 1e-9, <= 1e-2
        Of the corners under the mean load of a block: small for rigid blocks. Between 1e-6 and 1e-7
        no limit of ten measured models changes by more than half a degree.
    tangential : > 0, < inf
        Tangential by normal stiffness. Discrete-element programs use 0.1 to 1. The default has the
        smallest largest miss of 41 published limits; two of them depend on it.
    loading
        In which order the load is put on: at once, as a ramp, or turned from upright.
    pace : > 0, < inf
        Factor on the default length of the steps.
    step_limit : >= 1
        Largest number of steps. Four times as many Newton steps end a run as well.
    """

    rest_within: float = 0.02
    fall: float = 0.3
    carrier: Carrier | None = None
    overlap: float = 1e-6
    tangential: float = 0.17
    loading: Loading = Loading.AT_ONCE
    pace: float = 1.0
    step_limit: int = 5000

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rest_within > self.fall:
            raise InputError(
                f"rest_within is {self.rest_within:g}, above fall, {self.fall:g}",
                remedy="give a smaller rest_within, or a larger fall",
            )


@dataclass(frozen=True, eq=False)
class SettlementPath(OneLine):
    """The motion of the blocks, for one carrier of the ends of the joints.

    Attributes
    ----------
    carrier
    outcome
    model
        The model at the beginning, with the interfaces of faces that were met on the way.
    positions : (s, n, 6) [m, rad]
        Positions of the blocks after each step that was kept, from the first to the last:
        translation of the centroid and rotation vector from the beginning, world axes.
    travel : (n,)
        Displacement of each block, divided by its size. A rotation counts with the radius of
        gyration.
    force : (k, 3) [N], local n, u, v of ``axes``, on block b, at the end
    point : (k, 3) [m], where the forces act at the end, a little outside the corners
    corner : (k, 3) [m], the corners at the end
    axes : (k, 3, 3) rows n, u, v at the end
    gap : (k,) [m], between the faces at the end; negative where they press
    residuals
        Of the forces on the moved blocks; None where they do not rest.
    share
        Of the load that the contacts do not carry at the end.
    steps, iterations
        Increments, and Newton steps.
    met
        Interfaces of faces that were apart at the beginning and have pressed since, the last ones.
    overlap
        That of the options, or smaller where springs were too soft.
    beyond : [m]
        How far corners that press at the end have gone beyond ends of faces that were taken as
        longer. Of what does not rest: how far, within ``rest_within``, beyond ends of others.
    tangential
        Tangential by normal stiffness.
    """

    carrier: Carrier
    outcome: Outcome
    model: Model
    positions: Floats
    travel: Floats
    force: Floats
    point: Floats
    corner: Floats
    axes: Floats
    gap: Floats
    residuals: Residuals | None
    share: float
    steps: int
    iterations: int
    met: tuple[int, ...] = ()
    overlap: float = 1e-6
    beyond: float = 0.0
    tangential: float = 0.17

    def _summary(self) -> str:
        return (
            f"{self.outcome.value}, travel {self.travel.max(initial=0.0):.3g}, {self.steps} steps"
        )

    @property
    def displacement(self) -> Floats:
        """(n, 6) [m, rad], the last of the positions."""
        return self.positions[-1]

    @property
    def moving(self) -> tuple[int, ...]:
        """Positions of the blocks that travelled a tenth or more of the longest travel."""
        most = float(self.travel.max(initial=0.0))
        return tuple(np.flatnonzero((self.travel >= 0.1 * most) & (self.travel > 0.0)).tolist())

    def moved_model(self) -> Model:
        """The blocks at the end, with an interface for each corner."""
        return moved_model(self.model, self.displacement, self.axes, self.corner)


def rest_residuals(path: SettlementPath) -> Residuals:
    """Equilibrium, tension and friction of the forces at the end, from points and cross products.

    A force where the faces are apart is a fault.
    """
    moved = moved_model(path.model, path.displacement, path.axes, path.point)
    found = check_forces(moved, path.force)
    open_ = (path.gap > 0.0) & (np.abs(path.force).max(axis=1, initial=0.0) > 0.0)
    apart = float(np.linalg.norm(path.force[open_], axis=1).max(initial=0.0))
    weight = float(np.linalg.norm(moved.load.wrench[:, :3], axis=1).max(initial=0.0))
    return Residuals(
        found.equilibrium, found.tension, found.cone, apart / weight if weight else 0.0
    )


@dataclass(frozen=True, eq=False)
class Settlement(Answer):
    """The motion of the blocks until they rest or fall.

    Attributes
    ----------
    outcome
    message
        One sentence for the user.
    paths
        One for each carrier of the ends of the joints; only one if there are no such ends, or if
        one was requested. The first has moving carriers.
    options
    time_s
    """

    outcome: Outcome
    message: str
    paths: tuple[SettlementPath, ...]
    options: SettlementOptions = field(default_factory=SettlementOptions)

    def __bool__(self) -> bool:
        raise TypeError("a settlement is neither true nor false; ask for .outcome or .rests")

    @property
    def path(self) -> SettlementPath:
        """The first path."""
        return self.paths[0]

    @property
    def rests(self) -> bool:
        """Whether it rests near its first position, for every carrier of the ends."""
        return self.outcome is Outcome.RESTS

    @property
    def iterations(self) -> int:
        """Newton steps of its paths."""
        return sum(path.iterations for path in self.paths)

    @property
    def model(self) -> Model:
        """The model at the beginning."""
        return self.path.model

    @property
    def displacement(self) -> Floats:
        """(n, 6) [m, rad], where the blocks of the first path end."""
        return self.path.displacement

    @property
    def travel(self) -> float:
        """Largest displacement of a block in the first path, relative to its size."""
        return float(self.path.travel.max(initial=0.0))

    @property
    def title(self) -> str:
        """How it ends."""
        return self.outcome.value[0].upper() + self.outcome.value[1:]

    def sentences(self) -> Sequence[Sentence]:
        """How it ends, also for each carrier of the ends of the joints where these differ."""
        ends = {Outcome.RESTS: Role.GOOD, Outcome.FALLS: Role.BAD, Outcome.DISPLACED: Role.BAD}
        said = [Sentence(self.outcome.value.upper(), ends.get(self.outcome, Role.UNSURE))]
        said.append(Sentence(self.message))
        if self.outcome in UNDECIDED:
            said += [Sentence(f"{_carried(path)}: {path.outcome.value}") for path in self.paths]
        return said

    def tables(self) -> Sequence[Table]:
        """The motion of the blocks, the longest first."""
        table = self.table()
        shown = len(self.paths) if self.outcome in UNDECIDED else 1
        moved = np.flatnonzero(table["travel"][: shown * len(self.assembly)] > 0.0)
        return [table.take(moved[np.argsort(-table["travel"][moved], kind="stable")])]

    def table(self) -> Table:
        """Motion of every block, path by path: translation, rotation vector, travel by size."""
        names = self.model.assembly.names
        motion = np.concatenate([path.displacement for path in self.paths])
        columns: dict[str, Any] = {
            "block": list(names) * len(self.paths),
            "carrier": [path.carrier.value for path in self.paths for _ in names],
            "move": motion[:, :3],
            "turn": motion[:, 3:],
            "travel": np.concatenate([path.travel for path in self.paths]),
        }
        return Table("motion", columns, {"move": "m", "turn": "rad"})

    def numbers(self) -> Mapping[str, Any]:
        """The outcome, and how each path ends."""
        rows, count = list(self.table()), len(self.assembly)
        return {
            "outcome": self.outcome,
            "message": self.message,
            "paths": [
                {
                    "carrier": path.carrier,
                    "tangential": path.tangential,
                    "outcome": path.outcome,
                    "travel": path.travel.max(initial=0.0),
                    "steps": path.steps,
                    "residuals": path.residuals,
                    "blocks": rows[i * count : (i + 1) * count],
                }
                for i, path in enumerate(self.paths)
            ],
        }

    def layers(self) -> Scene:
        """The motion of the blocks; a stage for each carrier of the ends of joints."""
        stages = tuple(self._stage(one) for one in self.paths)
        title, facts = f"drystone: {self.outcome.value}", self.asked.facts()
        return Scene(self.assembly, self.contacts, stages, title, facts)

    def _stage(self, path: SettlementPath) -> SceneStage:
        differ = self.outcome in UNDECIDED
        model, last = path.model, path.displacement
        assembly = model.assembly
        state = state_of(assembly)
        falls = path.outcome in (Outcome.FALLS, Outcome.DISPLACED)
        if falls:
            state[list(path.moving)] = State.FALLING
        moved = float(block_speed(assembly, last).max(initial=0.0))
        factor = max(enlargement(assembly, last), 1.0)
        many = len(path.positions)
        kept = max(2, min(many, MOST_STATES, MOST_POSITIONS // max(len(assembly), 1)))
        states = path.positions[np.unique(np.linspace(0, many - 1, kept).round().astype(int))]
        told = f"the largest displacement of a corner is {moved:.3g} m"
        if factor > 1.0:
            told += f", drawn {factor:.3g} times as long"
        up, gravity = directions(assembly, model.load)
        role = {Outcome.RESTS: Role.GOOD, Outcome.FALLS: Role.BAD}
        name = path.outcome.value
        headline = f"Undecided: {name} with the {_carried(path)}"
        return SceneStage(
            _carried(path) if len(self.paths) > 1 else "settlement",
            headline if differ else name[0].upper() + name[1:],
            f"{self.message}; {told}",
            state,
            Role.UNSURE if differ else role.get(path.outcome, Role.UNSURE),
            motion=factor * last if moved > 0.0 else None,
            path=factor * states if moved > 0.0 and len(states) > 1 else None,
            motion_name="Settlement" if factor == 1.0 else "Settlement, enlarged",
            plays=falls,
            up=up,
            gravity=gravity,
            layers=interface_layers(model.contacts) + load_layers(assembly, model.load),
        )


def _carried(path: SettlementPath) -> str:
    shear = f", shear stiffness {path.tangential:g} of the normal one"
    told = "" if path.tangential == SettlementPath.tangential else shear
    return f"ends of joints on the {path.carrier.value} block{told}"
