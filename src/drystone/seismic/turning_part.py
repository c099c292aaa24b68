"""A part of a model that turns about a line in an earthquake, as one rigid body and oscillator."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from drystone.answer.question import UP
from drystone.base.arrays import SAME, Bools, Floats, Ints, dot, lengths
from drystone.base.display import OneLine, named
from drystone.base.errors import InputError, counted, located
from drystone.base.ragged import linked
from drystone.base.table import Table
from drystone.checks import corner_motion
from drystone.geometry.frames import rotation_about
from drystone.geometry.kern import convex_hull
from drystone.io.opening import kept_of
from drystone.loads.applied import applied_loads
from drystone.loads.case import STANDARD_GRAVITY
from drystone.model import Model


@dataclass(frozen=True, eq=False)
class Oscillator(OneLine):
    """A mechanism as one oscillator.

    Attributes
    ----------
    multiplier
        Alpha 0: the horizontal acceleration by g at which the mechanism begins.
    masses
        The weights P that move, their places and their virtual displacements d along the
        earthquake: one for each body that moves as a whole, at its centroid, as the Circolare
        counts them. A body that is divided into more blocks is the same oscillator.
    reach : [m]
        Mean displacement of the weights at which no push is needed any more; NaN if not known.
    """

    multiplier: float
    masses: Table
    reach: float

    def _summary(self) -> str:
        return f"alpha0={self.multiplier:.4g}, {counted(len(self.masses), 'weight')}"

    @property
    def weight(self) -> float:
        """Of all masses that move [N]."""
        return float(self.masses["P"].sum())

    @property
    def share(self) -> float:
        """e*, the share of these masses that takes part."""
        carried, moved = self.masses["P"], self.masses["d"]
        second = float(carried @ moved**2)
        first = float(carried @ moved)
        return first**2 / (self.weight * second) if second > 0.0 else float("nan")

    @property
    def mass(self) -> float:
        """M* [kg]."""
        return self.share * self.weight / STANDARD_GRAVITY

    def acceleration(self, confidence: float) -> float:
        """a0* [m/s2]."""
        return self.multiplier * STANDARD_GRAVITY / (self.share * confidence)

    @property
    def displacement(self) -> float:
        """d0* [m]."""
        return self.reach / self.share


@dataclass(frozen=True, eq=False)
class Turning(OneLine):
    """A rigid part that turns about a line.

    Attributes
    ----------
    origin, axis : (3,)
        A point of the line, and its direction: the part turns counter-clockwise about it.
    along : (3,) unit
        Of the earthquake, level.
    name, place, force : (f,), (f, 3) [m], (f, 3) [N]
        Forces that keep their direction, where they act on the part.
    ties
        How many of these forces, the last ones, are of ties.
    couple : (3,) [N m]
    mass_name, mass_place, weight : (p,), (p, 3) [m], (p,) [N]
        Masses that are shaken.
    """

    origin: Floats
    axis: Floats
    along: Floats
    name: tuple[str, ...]
    place: Floats
    force: Floats
    ties: int
    couple: Floats
    mass_name: tuple[str, ...]
    mass_place: Floats
    weight: Floats

    def _summary(self) -> str:
        return f"about ({', '.join(f'{x:.4g}' for x in self.axis)}), {self.weight.sum():.4g} N"

    def multiplier(self, angle: float) -> float:
        """Alpha [1] at an angle [rad], by virtual work."""
        turn = rotation_about(self.axis, np.rad2deg(angle)).T
        arms = (self.place - self.origin) @ turn
        work = dot(self.force, np.cross(self.axis, arms)).sum() + self.couple @ self.axis
        shaken = self.weight @ (np.cross(self.axis, (self.mass_place - self.origin) @ turn))
        return float(-work / (shaken @ self.along))

    def moved(self, angle: float) -> float:
        """Mean displacement [m] of the weights along the earthquake at an angle [rad]."""
        arms = self.mass_place - self.origin
        away = arms @ rotation_about(self.axis, np.rad2deg(angle)).T - arms
        return float(self.weight @ (away @ self.along) / self.weight.sum())

    def overturned(self) -> float:
        """The angle [rad] at which no push is needed any more; NaN where there is none."""
        steps = np.linspace(0.0, 0.5 * np.pi, 181)[:-1]
        values = np.array([self.multiplier(one) for one in steps])
        after = np.flatnonzero(values <= 0.0)
        if not len(after) or after[0] == 0:
            return float("nan")
        end = int(after[0])
        return float(brentq(self.multiplier, steps[end - 1], steps[end], xtol=1e-12))

    def drawn_out(self, moved: float) -> tuple[str, float]:
        """The tie that is drawn out most where the weights have moved by [m], and how far [m]."""
        angle = float(brentq(lambda one: self.moved(one) - moved, 0.0, self.overturned()))
        pull, arms = self.force[-self.ties :], self.place[-self.ties :] - self.origin
        away = arms @ rotation_about(self.axis, np.rad2deg(angle)).T - arms
        out = -dot(away, pull) / lengths(pull)
        most = int(out.argmax())
        return self.name[len(self.name) - self.ties + most], float(out[most])

    def curve(self) -> tuple[Floats, Floats]:
        """Mean displacements [m] and multipliers, both (s,), until it overturns."""
        angles = np.linspace(0.0, np.nan_to_num(self.overturned()), 21)
        moved = np.array([self.moved(one) for one in angles])
        return moved, np.array([self.multiplier(one) for one in angles])

    def oscillator(self) -> Oscillator:
        """The mechanism as one oscillator."""
        end = self.overturned()
        reach = self.moved(end) if np.isfinite(end) else float("nan")
        moved = np.cross(self.axis, self.mass_place - self.origin) @ self.along
        masses = weights_that_move(self.mass_name, self.weight, self.mass_place, moved)
        return Oscillator(self.multiplier(0.0), masses, reach)

    def moments(self) -> Table:
        """What holds the part and what 1 g turns it by, as moments about the line.

        Each force acts so far behind the line, along the earthquake, and above it there. The sum of
        what holds by that of what turns is alpha 0.
        """
        shaken = self.weight[:, None] * self.along
        force, place = np.vstack([self.force, shaken]), np.vstack([self.place, self.mass_place])
        across = np.cross([0.0, 0.0, 1.0], self.along)
        arm = place - self.origin  # from the point of the line that is along the earthquake
        arm = arm - np.outer(arm @ across / (self.axis @ across), self.axis)
        turned = np.cross(arm, force) @ self.axis
        pushes = np.arange(len(force)) >= len(self.force)
        held, turned = np.where(pushes, 0.0, -turned), np.where(pushes, turned, 0.0)
        names = [*self.name, *(f"1 g on {one}" for one in self.mass_name)]
        if self.couple.any():
            names.append("moments that are applied")
            force, arm = np.vstack([force, np.zeros(3)]), np.vstack([arm, np.full(3, np.nan)])
            held, turned = np.append(held, -self.couple @ self.axis), np.append(turned, 0.0)
        columns = {"of": names, "force": force, "behind": -arm @ self.along, "above": arm[:, 2],
                   "holds": held, "turns": turned}  # fmt: skip
        units = {"force": "N", "behind": "m", "above": "m", "holds": "N m", "turns": "N m"}
        return Table("moments about the line", columns, units)


def weights_that_move(names: Sequence[str], weight: Floats, place: Floats, moved: Floats) -> Table:
    """The table of weights (p,) at places (p, 3) that are moved by (p,), the largest by 1."""
    moved = moved / max(float(np.abs(moved).max(initial=0.0)), 1e-300)
    columns = {"of": list(names), "P": weight, "place": place, "d": moved,
               "P_d": weight * moved, "P_d2": weight * moved**2}  # fmt: skip
    return Table("weights that move", columns, {"P": "N", "place": "m", "P_d": "N", "P_d2": "N"})


_CLOSE = 1e-3
"""How far a line may lie off a part by its size. Chosen: coordinates rounded to millimetres."""
_BED = math.sqrt(0.5)
"""Rise of the normal of a joint from which on it is a bed: less steep than 45 degrees. Chosen."""


def masses_of(model: Model, part: Ints) -> tuple[Floats, Floats, Ints, list[str]]:
    """Places (p, 3), weights (p,), blocks and names of masses: of blocks, then what they carry."""
    assembly = model.assembly
    part = part[~assembly.fixed[part]]
    place, mass, block = [assembly.centroid[part]], [assembly.mass[part]], [part]
    names = [assembly.names[i] for i in part]
    for one in model.load.masses:
        here = part[one.mass[part] != 0.0]
        place.append(one.place(assembly)[here])
        mass.append(one.mass[here])
        block.append(here)
        names += [f"{one.kind} on {assembly.names[i]}" for i in here]
    weight = STANDARD_GRAVITY * np.concatenate(mass)
    return np.vstack(place), weight, np.concatenate(block), names


def turning_of(
    model: Model,
    along: Floats,
    part: str | Sequence[str],
    line: Sequence[float] | None,
) -> tuple[Turning, Floats, list[str]]:
    """A part that turns about a line, its virtual motion (n, 6), and remarks."""
    assembly = model.assembly
    with located("part"):
        chosen = kept_of(assembly, part)
    chosen = chosen[~assembly.fixed[chosen]]
    if not len(chosen):
        raise InputError("has no free block", where="part", remedy="name blocks that can move")
    remarks = _whole(model, chosen)
    if line is not None:
        origin, axis = _line(line, along)
        remarks += _under(model, chosen, origin, axis)
        return *_about(model, chosen, along, origin, axis), remarks
    least, ends, found = _soonest(model, chosen, along)
    remarks += [f"the part turns about the edge of its foot from {ends}"] if ends else []
    return *found, [*remarks, *_sooner_ones(model, chosen, along, least)]


def _sooner_ones(model: Model, part: Ints, along: Floats, least: float) -> list[str]:
    """That a piece of a part turns sooner than the part, at ``least``, and presses on no other.

    Friction may hold what presses on another as the earthquake goes, or as it turns.
    """
    told: list[str] = []
    for name, own, out in _pieces(model, part):
        with suppress(InputError):  # a tie without a strength holds it
            sooner, _, (turning, _) = _soonest(model, own, along)
            pressed = out @ np.transpose([along, np.cross(turning.axis, UP)]) > _CLOSE
            if sooner < (1.0 - _CLOSE) * least and not pressed.any():
                least, names = sooner, named([model.assembly.names[i] for i in own])
                told = [f"{name} turns sooner, at {sooner:.4g} g: {names}"]
                if out.any():
                    told.append("while an upright joint slides both may turn sooner still: leave "
                                "out --part to ask all blocks at once")  # fmt: skip
    return told


def _pieces(model: Model, part: Ints) -> Iterator[tuple[str, Ints, Floats]]:
    """What stands on level beds of a part, then each side of its upright joints.

    By name, with its blocks and normals (m, 3) out of it, zero where it has no upright joint.
    """
    assembly, contacts = model.assembly, model.contacts
    a, b, normal = contacts.block_a, contacts.block_b, contacts.frame[:, 0]
    bottom = np.full(len(assembly), -np.inf)
    bottom[part] = [assembly.blocks[i].vertices[:, 2].min() for i in part]
    rise, height = np.abs(normal[:, 2]), contacts.centroid[:, 2]
    bed = (rise > _CLOSE) & ~contacts.ties
    for level in np.unique(bottom[part])[1:]:
        upper = bottom >= level
        uneven = (rise < 1.0 - _CLOSE) | (np.abs(height - level) > _CLOSE * assembly.size.max())
        if not ((upper[a] != upper[b]) & bed & uneven).any():
            yield f"what is above {level:.4g} m", np.flatnonzero(upper), np.zeros((1, 3))
    mine = np.isin(a, part) & np.isin(b, part) & ~contacts.ties
    group = linked(a[mine & bed], b[mine & bed], len(assembly))
    for one in np.unique(group[part]):
        out = normal * np.subtract(group[a] == one, group[b] == one, dtype=float)[:, None]
        yield "what upright joints part", part[group[part] == one], out[mine]


def _soonest(model: Model, part: Ints, along: Floats) -> tuple[float, str, tuple[Turning, Floats]]:
    """How a part turns about its foot: the least multiplier, the edge unless a corner, and that."""
    lines = _edges_of_foot(model, part, along)
    found = [_about(model, part, along, start, end - start) for start, end in lines]
    alpha = np.array([turning.multiplier(0.0) for turning, _ in found])
    best = int(np.argmax(alpha <= alpha.min() + SAME))  # about a corner all are the same
    size = SAME * float(model.assembly.size.max())
    ends = [np.where(np.abs(end) > size, end, 0.0) for end in lines[best]]
    edge = " to ".join(", ".join(f"{x:.4g}" for x in end) for end in ends)
    return float(alpha[best]), edge if best else "", found[best]


def _about(
    model: Model, chosen: Ints, along: Floats, origin: Floats, axis: Floats
) -> tuple[Turning, Floats]:
    """A part that turns about a line, and its virtual motion (n, 6)."""
    assembly, axis = model.assembly, axis / np.linalg.norm(axis)
    applied = applied_loads(assembly, model.load.beside_masses)
    mine = np.isin(applied.block, chosen)
    at, weight, _, names = masses_of(model, chosen)
    own, others = weight[: len(chosen)], weight[len(chosen) :]  # the part is one body
    masses = np.vstack([own @ at[: len(chosen)] / own.sum(), at[len(chosen) :]])
    motion = np.zeros((len(assembly), 6))
    motion[chosen, :3] = np.cross(axis, assembly.centroid[chosen] - origin)
    motion[chosen, 3:] = axis
    pulls = pulls_of(model, chosen, motion)
    place = [masses, applied.point[mine], *(x[None] for _, x, _ in pulls)]
    carried = [one.wrench[chosen[one.mass[chosen] != 0.0], :3] for one in model.load.masses]
    force = [assembly.mass[chosen].sum() * applied.acceleration[None], *carried,
             applied.force[mine], *(x[None] for *_, x in pulls)]  # fmt: skip
    loads = [f"load on {assembly.names[i]}" for i in applied.block[mine]]
    shaken = ("own weight", *names[len(chosen) :])
    name = (*shaken, *loads, *(f"tie {one}" for one, *_ in pulls))
    turning = Turning(
        origin, axis, along, name, np.vstack(place), np.vstack(force), len(pulls),
        applied.moment[mine].sum(axis=0), shaken, masses, np.concatenate([[own.sum()], others]),
    )  # fmt: skip
    return turning, motion


def _whole(model: Model, part: Ints) -> list[str]:
    """Refuse a part of several pieces, or without what stands on it alone; say what else is on it.

    Joints whose normal rises carry what is above them.
    """
    assembly, contacts = model.assembly, model.contacts
    names = np.array(assembly.names)
    mine = np.isin(np.arange(len(assembly)), part)
    a, b = contacts.block_a, contacts.block_b
    within = mine[a] & mine[b]
    first = part[np.unique(linked(a[within], b[within], len(assembly))[part], return_index=True)[1]]
    if len(first) > 1:
        told = f"is {len(first)} pieces that do not touch: of {named(names[first].tolist())}"
        raise InputError(told, where="part", remedy="name what is between, or ask for each alone")
    rise = contacts.frame[:, 0, 2]
    rests = ~contacts.ties & (np.abs(rise) > _CLOSE)
    below, above = np.where(rise > 0.0, (a, b), (b, a))[:, rests]

    def raised(start: Bools, through: Bools) -> Bools:
        """What stands on some blocks, at once or through others."""
        reached = start
        while len(more := above[reached[below] & ~reached[above] & through[above]]):
            reached = reached.copy()
            reached[more] = True
        return reached

    held = raised(assembly.fixed, ~mine)
    left = np.flatnonzero(raised(mine, ~held) & ~mine)
    if len(left):
        told = f"leaves out what stands on it alone: {named(names[left].tolist())}"
        raise InputError(told, where="part", remedy="name it too")
    both = np.unique(above[mine[below] & held[above] & ~assembly.fixed[above]])
    if not len(both):
        return []
    told = named(names[both].tolist())
    return [f"what {told} lays on the part is not counted: name it too, or give it as a load"]


def _foot(model: Model, part: Ints) -> Floats:
    """Corners (c, 3) of the beds of a part: of blocks that lie on others only; else its lowest.

    Beds need not be level, nor at one height.
    """
    assembly, contacts = model.assembly, model.contacts
    rise = contacts.frame[:, 0, 2]
    above = np.where(rise > 0.0, contacts.block_b, contacts.block_a)
    below = np.where(rise > 0.0, contacts.block_a, contacts.block_b)
    lies = (np.abs(rise) > _BED) & ~contacts.ties & np.isin(above, part)
    inside = np.isin(below, part)
    beds = lies & ~inside & ~np.isin(above, above[lies & inside])
    corners = np.vstack([assembly.blocks[i].vertices for i in part])
    lowest = corners[corners[:, 2] <= corners[:, 2].min() + SAME * assembly.size.max()]
    return contacts.point[beds[contacts.interface]] if beds.any() else lowest


def _edges_of_foot(model: Model, part: Ints, along: Floats) -> list[tuple[Floats, Floats]]:
    """Lines about which a part falls along a direction, by two points of each.

    The first is across the direction, through the corner of its foot that is farthest along, or the
    edge there, which need not be level; the others are the edges of the hull of its foot, seen from
    above, over which it is pushed.
    """
    low = _foot(model, part)
    across, far, flat = np.cross(UP, along), low[np.argmax(low @ along)], convex_hull(low[:, :2])
    foot = low[lengths(low[:, None, :2] - flat).argmin(axis=0)]
    edges = zip(foot, np.roll(foot, -1, axis=0), strict=True) if len(foot) > 2 else ()
    over = [(a, b) for a, b in edges if (b - a) @ across > _CLOSE * np.linalg.norm(b - a)]
    square = [(a, b) for a, b in over if abs((b - a) @ along) <= _CLOSE * np.linalg.norm(b - a)]
    return [*(square[:1] or [(far, far + across)]), *over]


def _line(line: Sequence[float], along: Floats) -> tuple[Floats, Floats]:
    """A point of the line that was asked for, and its direction: the part falls along."""
    ends = np.reshape(np.asarray(line, dtype=np.float64), (-1,))
    if len(ends) != 6:
        raise InputError(f"has {len(ends)} numbers", where="line", remedy="give X,Y,Z,X,Y,Z")
    axis = ends[3:] - ends[:3]
    size = float(np.linalg.norm(axis))
    forward = float(axis @ np.cross(UP, along))
    if abs(forward) <= 1e-6 * size:
        what = "is vertical or along the direction: nothing overturns"
        raise InputError(what, where="line", remedy="give a level line across the direction")
    if abs(axis[2]) > _CLOSE * size:
        raise InputError("is not level", where="line", remedy="give its two ends the same height")
    return ends[:3], axis / size * np.sign(forward)


def _under(model: Model, part: Ints, origin: Floats, axis: Floats) -> list[str]:
    """Refuse a line that is not under a part; say where it is behind the edge of its foot."""
    assembly, foot = model.assembly, _foot(model, part)
    bottom = np.array([assembly.blocks[i].vertices[:, 2].min() for i in part])
    corners = np.vstack([assembly.blocks[i].vertices for i in part])
    near = _CLOSE * float(np.linalg.norm(np.ptp(corners, axis=0)))
    lowest, highest = float(foot[:, 2].min()), float(foot[:, 2].max())
    rise = float(origin[2] - np.clip(origin[2], lowest, highest))
    if abs(rise) > near:
        remedy = f"give z = {lowest:.4g}"
        above = [assembly.names[i] for i in part[bottom >= origin[2] - near]]
        if 0 < len(above) < len(part):
            remedy += f", or name the blocks above it alone: {named(above)} (--part)"
        told = f"lies {abs(rise):.4g} m {'above' if rise > 0.0 else 'below'} the part's lowest edge"
        raise InputError(told, where="line", remedy=remedy)
    ahead = np.cross(axis, UP)
    feet = (foot - origin) @ ahead
    behind = float(feet.max())
    beside = float(np.clip(0.0, feet.min(), behind))
    if abs(beside) > near:
        told = f"lies {abs(beside):.4g} m beside the part's lowest edges"
        remedy = f"give one through {', '.join(f'{x + 0.0:.4g}' for x in origin + behind * ahead)}"
        raise InputError(told, where="line", remedy=remedy)
    return [f"the line lies {behind:.4g} m behind the part's edge"] if behind > near else []


def pulls_of(model: Model, part: Ints, motion: Floats) -> list[tuple[str, Floats, Floats]]:
    """Block, place (3,) [m] and pull (3,) [N] of each tie that a motion (n, 6) of a part stretches.

    Others go slack.
    """
    contacts, assembly = model.contacts, model.assembly
    stretched = contacts.corners.min(corner_motion(assembly, contacts, motion)[:, 0]) < 0.0
    found = []
    for i in np.flatnonzero(contacts.ties & stretched).tolist():
        blocks = contacts.block_a[i], contacts.block_b[i]
        inside = np.isin(blocks, part)
        if inside.all():
            continue
        name, strength = assembly.names[blocks[int(inside[1])]], contacts.tie_strength[i]
        if not np.isfinite(strength):
            remedy = "give it one: --tie BLOCK:BLOCK:20kN"
            raise InputError(f"the tie of '{name}' has no strength", where="part", remedy=remedy)
        along, here = contacts.frame[i, 0], contacts.centroid[i]
        there, pull = here + contacts.rod[i] * along, strength * along
        found.append((name, here, pull) if inside[1] else (name, there, -pull))
    return found
