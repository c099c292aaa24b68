"""What falling blocks need, as numbers: the least change of each kind with which they stand.

The help that a structure needs as a function of its vertices, with its gradient.

Help is props under blocks and pulls across joints that open. In the compliant state the blocks rest
on corner springs with friction; weak ground springs are the props, and weak glue pulls. With w the
wrenches of the ground, w_i that of one of n blocks, and t the pulls, scaled,

    J = sum_i (w_i . w_i) / (n s_i) + (t . t) / (p . p),    s_i = p_i . p_i,
    w = g M q,    t = c kn max(dn, 0),    d = A' q,    A f(A' q) + p - g M q = 0.

Each block counts by its own load: a block that falls does not need less help when it gets small.
Where the structure stands and is to stay so, all blocks count by the mean, s_i = (p . p) / n.
The gradient follows from one more solve (adjoint state): with S = A D A' + g M the tangent, and
b and e the derivatives of J by w, and by the displacements d of corners,

    S' lambda = g M b + A e,    h = e - D' A' lambda,
    dJ = lambda . (dA f) + q . (dA h) + lambda . dp + (partial derivative of J by p) . dp,

where dA and dp are the changes of the equilibrium matrix and of the load with the vertices.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from drystone.base.arrays import Floats, Ints, cross, frozen
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.contacts import Contacts
from drystone.design.bench import Bench
from drystone.design.changed_model import acceleration_of
from drystone.design.changes import (
    Change,
    ballast_change,
    friction_change,
    glue_changes,
    joint_change,
)
from drystone.design.corner_following import Corners
from drystone.design.margin import SMALL_REGION
from drystone.design.props import NO_PROPS, SHARES, PropSearch, find_props, tops_of
from drystone.design.regions import tension_if_glued
from drystone.design.vertex_places import BlockVertices
from drystone.mechanics.law import Compliance, uniform
from drystone.mechanics.rest import find_rest
from drystone.mechanics.rest_state import RestOptions, RestState
from drystone.mechanics.statics import Statics
from drystone.model import Model
from drystone.stability.problem import Problem

SEARCHED = 12
"""Number of blocks of a region for which a prop is tried, those with the largest need first; fewer
in a large region. In a region of more blocks no ballast is tried: a weight on one of them hardly
ever holds it."""

NEEDED = ("prop", "friction", "ballast", "turn", "glue")
"""The kinds of help that are searched; the same as of mends."""


def refuse_other_kinds(kinds: Iterable[str], known: Sequence[str], what: str) -> None:
    """Refuse kinds of needs or mends that do not exist.

    Raises
    ------
    InputError
    """
    for kind in kinds:
        if kind not in known:
            each = "give several each on its own; " if "," in kind else ""
            remedy = f"{each}choose from {', '.join(known)}"
            raise InputError(f"there is no kind of {what} '{kind}'", remedy=remedy)


@dataclass(frozen=True, eq=False)
class Pull(OneLine):
    """Tension that a joint would carry if it were glued.

    Attributes
    ----------
    interface
    force : [N]
        Sum over its corners.
    point : (3,) [m]
        Where it acts.
    """

    interface: int
    force: float
    point: Floats


@dataclass(frozen=True, eq=False)
class Need(OneLine):
    """The least change of a kind with which a region stands.

    Attributes
    ----------
    value
        A weight or the strength of glue [N], or the turn of a joint [degrees], without a sign. Each
        glued joint carries this pull and this shear, spread over its area.
    at
        The block that is weighted, or the interfaces that are glued or turned.
    jams
        Largest force of a joint by the load of the region, where it holds by jamming; else 0.
    """

    value: float
    at: tuple[int, ...]
    jams: float = 0.0


@dataclass(frozen=True, eq=False)
class Needs(OneLine):
    """Help with which a region would stand; ``None`` if not found.

    Blocks and interfaces are those of the whole model.

    Attributes
    ----------
    wrench : (r, 6) [N, N m]
        The wrench that would hold each block of the region, about its centroid.
    force, point : (3,) [N], (3,) [m]
        The same as one force, and its point of action.
    pulls
        The joints in tension if all were glued without limit, the largest tension first.
    props
        The prop with the least force, else a few that hold it together; and what was tried.
    friction
        Least coefficient of the joints of the region.
    ballast
        The least weight on one block.
    turn
        The least turn of one joint about one of its edges.
    glue
        Glue alone with which it stands, the least strength first: in the joints of two blocks each,
        or for regions of more than four blocks in all joints that pull, up to forty blocks.
    """

    wrench: Floats
    force: Floats
    point: Floats
    pulls: tuple[Pull, ...]
    props: PropSearch = NO_PROPS
    friction: float | None = None
    ballast: Need | None = None
    turn: Need | None = None
    glue: tuple[Need, ...] = ()

    @property
    def kinds(self) -> set[str]:
        """The kinds of mends that hold the region alone."""
        found = {name for name in ("friction", "ballast", "turn", "glue") if getattr(self, name)}
        return found | ({"prop"} if self.props.props else set())


def search_needs(bench: Bench, needs: Needs, kinds: Sequence[str]) -> Iterator[dict[str, Any]]:
    """The needs of the region of a bench, one after the other, as fields of :class:`Needs`.

    ``needs`` is what is known of them, ``kinds`` of :data:`NEEDED` what is searched.

    Raises
    ------
    Stopped
    """
    each: list[tuple[str, Callable[[], dict[str, Any]]]] = [
        ("prop", lambda: {"props": props_of(bench, needs).renumbered(bench.blocks)}),
        ("friction", lambda: {"friction": _friction(bench)}),
    ]
    if len(bench.own) <= SEARCHED and acceleration_of(bench.local).any():
        tops, count = tops_of(bench.local, bench.own), len(bench.own)
        weights = [ballast_change(bench.local, count, {i: at}) for i, at in tops.items()]
        on = [bench.region[i] for i in tops]
        each.append(("ballast", lambda: {"ballast": _smallest(bench, weights, on)}))
    if len(bench.own) <= SMALL_REGION:
        each.append(("turn", lambda: {"turn": _turn(bench)}))
    if bench.large:
        each.append(("glue", lambda: {"pulls": pulls_of_region(bench)}))
    else:
        each.append(("glue", lambda: {"glue": _glue(bench, needs.pulls)}))
    yield from (found() for kind, found in each if kind in kinds)


def props_of(bench: Bench, needs: Needs) -> PropSearch:
    """The props that hold the region of a bench, sought at the blocks with the largest need first.

    Raises
    ------
    Stopped
    """
    few = SMALL_REGION if bench.large else SEARCHED
    size = np.linalg.norm(needs.wrench[:, :3], axis=1)
    small = len(bench.own) <= SMALL_REGION
    return find_props(
        bench.local,
        bench.own,
        bench.motion,
        bench.stop,
        single=np.argsort(-size, kind="stable")[:few].tolist(),
        shares=SHARES if small else SHARES[:1],
    )


def _friction(bench: Bench) -> float | None:
    """The least coefficient of all joints."""
    joints = range(bench.local.contacts.count)
    value = bench.least(friction_change(bench.local, joints, "")) if joints else None
    return None if value is None else round(value, 6)


def _turn(bench: Bench) -> Need | None:
    """The least turn of a joint, to either side."""
    turns, at = [], []
    for k, side in product(range(bench.local.contacts.count), (1.0, -1.0)):
        with contextlib.suppress(InputError):  # it is not plane
            turns.append(joint_change(bench.local, "turn", {k: side}))
            at.append(int(bench.interfaces[k]))
    return _smallest(bench, turns, at)


def _glue(bench: Bench, pulls: Sequence[Pull]) -> tuple[Need, ...]:
    """Glue alone, the least strength first."""
    inner = {int(whole): k for k, whole in enumerate(bench.interfaces)}
    pulling = [(inner[pull.interface], pull.force) for pull in pulls]
    found = []
    for some, change in glue_changes(bench.local, len(bench.own), pulling, SMALL_REGION).items():
        value = bench.least(replace(change, steps=change.steps[-1:]))
        if value is not None:
            found.append(Need(value, tuple(bench.interfaces[list(some)].tolist())))
    return tuple(sorted(found, key=lambda one: one.value))


def _smallest(bench: Bench, changes: Sequence[Change], at: Sequence[int]) -> Need | None:
    """The smallest of the least values of some changes, each of a block or of a joint."""
    best = bench.smallest(changes)
    if best is None:
        return None
    jam = bench.jam(*best)
    return Need(best[1], (at[list(changes).index(best[0])],), jam.times if jam else 0.0)


def pulls_of_region(bench: Bench) -> tuple[Pull, ...]:
    """The joints of the region of a bench that would pull if all were glued."""
    tension = tension_if_glued(bench.local, bench.stop)
    return pulls_of(bench.local.contacts, tension, bench.interfaces)


def pulls_of(contacts: Contacts, tension: Floats | None, interfaces: Ints) -> tuple[Pull, ...]:
    """The joints of a glued structure in tension, the largest tension first.

    Parameters
    ----------
    contacts
    tension : (k,) [N]
        Of each corner.
    interfaces : (m,)
        Positions of its interfaces in the whole model.
    """
    if tension is None or not contacts.count or contacts.count != len(interfaces):
        return ()
    total = np.bincount(contacts.interface, tension, minlength=contacts.count)
    pulls = []
    for i in np.argsort(-total):
        if total[i] <= 1e-3 * total.max() or total[i] <= 0.0:
            break
        corners = slice(contacts.start[i], contacts.start[i + 1])
        point = tension[corners] @ contacts.point[corners] / total[i]
        pulls.append(Pull(int(interfaces[i]), float(total[i]), frozen(point)))
    return tuple(pulls)


def one_force(model: Model, blocks: tuple[int, ...], wrench: Floats) -> tuple[Floats, Floats]:
    """The sum of wrenches on some blocks as one force (3,) [N], and its point of action (3,) [m].

    Of the points on the line of action it is the one nearest to the middle of the blocks.
    """
    centroid = model.assembly.centroid[list(blocks)]
    middle: Floats = centroid.mean(axis=0)
    force: Floats = wrench[:, :3].sum(axis=0)
    moment = wrench[:, 3:].sum(axis=0) + np.cross(centroid - middle, wrench[:, :3]).sum(axis=0)
    square = float(force @ force)
    return force, middle + np.cross(force, moment) / square if square > 0.0 else middle


_GLUE = 0.02
"""Stiffness of the glue, by that of the joint, divided by the stiffness of the ground. Chosen: an
arch of 100 voussoirs that falls is not found to stand with 1, and is with 0.02; an
overhang of four bricks ends 0.6 % short of its limit with 0.01."""

GROUND = 1e-6
"""Stiffness of the ground, chosen: of arches of 12 blocks that stand it carries 1.5e-5 of the load
at most, of one that is 5 % too thin 0.019."""

_LIGHT = 1e-12
"""Share of the mean square load of all blocks that is added to that of each: some have no load."""


@dataclass(frozen=True, eq=False)
class Form:
    """A model whose vertices may move while its blocks keep touching at the same corners.

    Stiffnesses and scales are those of the model as given: they do not follow the vertices until
    contacts are found anew.

    Attributes
    ----------
    model
    bodies
    corners
    statics
        Of the model as given.
    springs
    ground
        Stiffness of the ground, scaled.
    each
        Whether the prop of each block counts by its own load.
    """

    model: Model
    bodies: BlockVertices
    corners: Corners
    statics: Statics
    springs: Compliance
    ground: float
    each: bool = True

    @classmethod
    def of(
        cls, model: Model, ground: float = GROUND, glue: float = _GLUE, *, each: bool = True
    ) -> Form:
        """The form of a model with plane joints; ``glue`` as :data:`_GLUE`.

        Raises
        ------
        InputError
            A corner is neither a vertex nor a crossing of edges, or the load moves supports.
        """
        model = model if model.active.all() else model.with_contacts(
            model.contacts.select(model.active)
        )  # fmt: skip
        statics = Problem.build(model).statics
        bodies = BlockVertices.of(model.assembly)
        return cls(
            model,
            bodies,
            Corners.of(model, bodies),
            statics,
            uniform(statics, slip=1.0, glue=glue * ground),
            ground,
            each,
        )

    @cached_property
    def density(self) -> Floats:
        """(n,) [kg/m3]."""
        return self.model.assembly.mass / self.model.assembly.volume

    @cached_property
    def acceleration(self) -> Floats:
        """Of all masses (3,) [m/s2]."""
        return acceleration_of(self.model)

    @cached_property
    def extra(self) -> Floats:
        """Load (n, 6) [N, N m] that is no weight, about the centroids of the model as given."""
        extra = np.array(self.model.load.wrench)
        extra[:, :3] -= self.model.assembly.mass[:, None] * self.acceleration
        return extra

    def statics_at(self, vertex: Floats) -> Statics:
        """The statics with vertices (v, 3) elsewhere, in the scales of the model as given."""
        model, statics = self.model, self.statics
        contacts = model.contacts
        volume, centroid = self.bodies.measures(vertex)
        point = self.corners.points(vertex)
        frame = self.corners.frames(point)
        a, b = (end[contacts.interface] for end in (contacts.block_a, contacts.block_b))
        length = model.assembly.size
        force = (self.density * volume)[:, None] * self.acceleration + self.extra[:, :3]
        shift = model.assembly.centroid - centroid
        moment = self.extra[:, 3:] + cross(shift, self.extra[:, :3])
        load = np.concatenate([force, moment / length[:, None]], axis=1) / statics.force_unit
        return replace(
            statics,
            lever_a=(point - centroid[a]) / length[a, None],
            lever_b=(point - centroid[b]) / length[b, None],
            frame=frame[contacts.interface],
            load=load[statics.free],
        )

    def help_at(self, vertex: Floats) -> tuple[float, Floats]:
        """The help that is needed, J, and its gradient (v, 3) [1/m]."""
        statics = self.statics_at(vertex)
        options = RestOptions(ground=self.ground, tolerance=1e-11)
        state = find_rest(statics, self.springs, options)
        weight = self.ground * statics.mass_matrix
        carried = weight * state.motion
        whole = float((statics.load**2).sum())
        pulled = float((state.tension**2).sum()) / whole
        count = len(carried)
        mean = whole / count
        square = (statics.load**2).sum(axis=1, keepdims=True) if self.each else mean
        own = count * (square + _LIGHT * mean)
        props = (carried**2).sum(axis=1, keepdims=True) / own
        value = float(props.sum()) + pulled
        by_corner = np.zeros((statics.corner_count, 3))
        stiffness = self.springs.glue * self.springs.normal
        by_corner[:, 0] = 2.0 * stiffness * state.tension / whole
        by_motion = 2.0 * weight * carried / own + statics.wrench(by_corner)
        adjoint, turned = self._adjoint(statics, state, weight, by_motion)
        gradient = self._work_gradient(vertex, statics, state.force, adjoint)
        gradient += self._work_gradient(vertex, statics, by_corner + turned, state.motion)
        shares = props / own
        of_mean = float(shares.sum())
        by_square = count * shares + _LIGHT * of_mean if self.each else (1.0 + _LIGHT) * of_mean
        by_load = adjoint - 2.0 * (by_square + pulled / whole) * statics.load
        return value, gradient + self._load_gradient(vertex, by_load)

    def _adjoint(
        self, statics: Statics, state: RestState, weight: Floats, by_motion: Floats
    ) -> tuple[Floats, Floats]:
        """The adjoint motion lambda (n, 6), and forces h (k, 3)."""
        kn = self.springs.normal
        moved = statics.displacement(state.motion)
        pressed = moved[:, 0] < 0.0
        normal = np.where(pressed, -kn * moved[:, 0], 0.0)
        by_slide, by_normal = self.springs.friction(normal, moved[:, 1:]).slope()
        tangent = np.zeros((statics.corner_count, 3, 3))
        tangent[:, 0, 0] = np.where(pressed, kn, self.springs.glue * kn)
        tangent[:, 1:, 0] = -by_normal * np.where(pressed, kn, 0.0)[:, None]
        tangent[:, 1:, 1:] = by_slide
        back = np.ascontiguousarray(np.swapaxes(tangent, 1, 2))
        adjoint = statics.maps.factorise(back, weight)(by_motion)
        forces = -np.einsum("kij,kj->ki", back, statics.displacement(adjoint))
        return adjoint, forces

    def _work_gradient(
        self, vertex: Floats, statics: Statics, force: Floats, motion: Floats
    ) -> Floats:
        """Derivative (v, 3) of the work of corner forces (k, 3) on a motion (n, 6), both scaled."""
        assembly, contacts = self.model.assembly, self.model.contacts
        whole = statics.physical_motion(motion, len(assembly), 1.0)
        a, b = (end[contacts.interface] for end in (contacts.block_a, contacts.block_b))
        world = np.einsum("ki,kij->kj", force, statics.frame)
        turn_a, turn_b = cross(world, whole[a, 3:]), cross(world, whole[b, 3:])
        by_centroid = np.zeros((len(assembly), 3))
        np.add.at(by_centroid, a, turn_a)
        np.add.at(by_centroid, b, -turn_b)
        moved = np.einsum("kij,ki->kj", statics.frame, statics.displacement(motion))
        by_axis = force[:, :, None] * moved[:, None, :]
        by_frame = np.zeros((contacts.count, 3, 3))
        np.add.at(by_frame, contacts.interface, by_axis)
        point = self.corners.points(vertex)
        by_point = turn_b - turn_a + self.corners.frames_pulled_back(point, by_frame)
        gradient = self.corners.points_pulled_back(vertex, by_point)
        none = np.zeros(len(assembly))
        return gradient + self.bodies.measures_pulled_back(vertex, none, by_centroid)

    def _load_gradient(self, vertex: Floats, motion: Floats) -> Floats:
        """Derivative (v, 3) of the work of the load on a scaled motion (n, 6)."""
        assembly = self.model.assembly
        whole = self.statics.physical_motion(motion, len(assembly), 1.0) / self.statics.force_unit
        by_volume = self.density * (whole[:, :3] @ self.acceleration)
        by_centroid = -cross(self.extra[:, :3], whole[:, 3:])
        return self.bodies.measures_pulled_back(vertex, by_volume, by_centroid)


@dataclass(frozen=True, eq=False)
class KnownNeeds:
    """What the changes of a region are proposed from.

    Attributes
    ----------
    bench
    needs
        What the diagnosis found that would hold it, without a margin.
    known
        Whether that is of the same local model: not where supports have moved.
    """

    bench: Bench
    needs: Needs
    known: bool
