"""What an analysis answers: verdict, forces, motion, and the residuals that prove it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer import Answer, Role, Scene, SceneStage, Sentence, Verdict
from drystone.assembly import Blocks
from drystone.base.arrays import SAME, lengths
from drystone.base.display import rounded_down, rounded_up
from drystone.base.errors import InputError, counted
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.geometry.quadrature import ACCURATE
from drystone.joints import (
    FAINT,
    SWAY,
    Resultants,
    ThrustLine,
    by_joint,
    corner_pressure,
    foot_pressed,
    joint_table,
    on_an_edge,
    thrust_line,
)
from drystone.loads.applied import is_vertical, loads_apart
from drystone.results.solution import MARGINS, Sensitivity, Solution, reaction_table
from drystone.results.stage import stage_of
from drystone.supports import own_blocks
from drystone.ties import joint_words


@dataclass(frozen=True, eq=False)
class Result(Solution, Answer):
    """Answer of an analysis, with the model that it belongs to.

    Its fields are those of :class:`Solution`.
    """

    def _summary(self) -> str:
        blocks, joints = int(own_blocks(self.assembly).sum()), self.contacts.count
        return (
            f"{self.verdict}, {counted(blocks, 'block')}, {counted(joints, 'interface')}, "
            f"'{self.message}'"
        )

    @property
    def title(self) -> str:
        """The verdict as a plain sentence."""
        if self.verdict is Verdict.UNSTABLE:
            if len(self.falling) > 1:
                own = int(own_blocks(self.assembly).sum())
                return f"Falls: {len(self.falling):,} of {own:,} blocks"
            return f"Falls: block '{self.falling_names[0]}'" if self.falling else "Falls"
        if self.verdict is Verdict.UNDECIDED:
            return "Not decided: neither standing nor falling was shown"
        if self.verdict is Verdict.EQUILIBRIUM_EXISTS:
            return "Some forces balance the loads; whether it stands was not asked"
        if self.settlement is not None:
            return "Stands after settling: it depends on how the joints press"
        if self.samples.standing == self.samples.tried:
            return "Stands"
        if self.sensitive_to == (Sensitivity.PRESSURE,):
            return "Stands on the corners of its joints"
        tried, standing = self.samples.tried, self.samples.standing
        return f"Contact stiffness decides: stands for {standing} of {tried} tried"

    def sentences(self) -> Sequence[Sentence]:
        """The verdict, how it was found, and the contact stiffnesses."""
        word = self.verdict.upper() + (" (sensitive)" if self.sensitive else "")
        said = [Sentence(word, Role.of(self.verdict)), Sentence(self.message)]
        if self.samples.tried and self.verdict is not Verdict.UNSTABLE:
            tried, standing = self.samples.tried, self.samples.standing
            words = f"stands for {standing} of {tried} tried"
            words += " without a limit of strength" if self.contacts.crushes.any() else ""
            said.append(Sentence(f"contact stiffness, which nobody knows: {words}"))
        return [one for one in (*said, *self.margins()) if one.text]

    def margins(self) -> Sequence[Sentence]:
        """How far what stands is from falling, and what it needs."""
        said = []
        if self._safety:
            said.append(Sentence(f"safety: {self._safety}: a bound, it may fall before"))
        if self._rubbing:
            said.append(
                Sentence(f"friction: forces balance the loads {self._rubbing}: a bound too")
            )
        if self.verdict is Verdict.STABLE and self.force is not None:
            said += self._strength()
            said += [Sentence(self.zero_margin), Sentence(self.corners_needed), *self._foot()]
        return said

    def _foot(self) -> list[Sentence]:
        """Where what stands on one joint presses on it, beside its kern."""
        joints = self.contacts.joints
        found, _ = by_joint(self.contacts, self.resultants, self.utilisation)
        far, share = foot_pressed(self.assembly, joints, found) or (0.0, 0.0)
        if share < ACCURATE:  # in the middle
            return []
        words = f"foot: the resultant is {quantity(far, 'm')} from its middle, "
        if share <= 1.0:
            way = f"{rounded_up(100.0 * share, 3):g} % of the way to the edge of the kern"
            words += f"inside its kern ({way})"
        else:
            way = f"{rounded_up(share, 3):g} times the way to the edge of the kern, not of the foot"
            words += f"outside its kern, at {way}: without tension a part of the foot opens"
        return [Sentence(words)]

    @property
    def _safety(self) -> str:
        margin = self.tilt_margin
        if margin is None:
            return ""
        if is_vertical(self.load):
            least = f" (least about {self.tilt_about})" if self.tilt_about else ""
            return f"forces balance a tilt about x or y of {rounded_down(margin):g} degrees{least}"
        push = rounded_down(math.tan(math.radians(margin)))
        along = {"y": "x", "-y": "-x", "x": "-y", "-x": "y"}.get(self.tilt_about, "")
        least = f" (least along {along})" if along else ""
        words = f"forces balance a push along x or y of {push:g} of the weight of blocks and what"
        return f"{words} they carry, on top of the loads{least}"

    @property
    def _rubbing(self) -> str:
        share = self.friction_margin
        if share is None:
            return ""
        return f"with {rounded_up(share):g} times the friction" if share else "without friction"

    def _strength(self) -> list[Sentence]:
        """How much of its strength the most pressed joint uses, and the loads at which it crushes.

        In proportion to the loads the forces that were found crush the first joint; the last ones
        are those of the limit.
        """
        use = self.strength_use
        if not use.max(initial=0.0) > 0.0:
            return []
        at = int(np.argmax(use))
        most = rounded_up(100.0 * use[at])
        what, which, fails = joint_words(self.assembly, self.contacts, at)
        words = f"strength: the {which} uses {most:g} %"
        words += f"; the first {what} {fails} at {rounded_down(1.0 / use[at]):g} times all loads"
        if self.crushing_factor is not None:
            words += f", and no forces are left at {rounded_down(self.crushing_factor):g} times"
        return [Sentence(words)]

    @cached_property
    def zero_margin(self) -> str:
        """What stands exactly above an edge, in words; or empty."""
        joints, names = self.contacts.joints, self.assembly.names
        found, _ = by_joint(self.contacts, self.resultants, np.zeros(self.contacts.count))
        near = SAME if self.settlement is None else 10.0 * SWAY
        pairs = on_an_edge(self.assembly, joints, found, near)
        if not pairs:
            return ""
        block, others = pairs[0]
        where = "above an edge of its joint" if len(others) == 1 else "on the line of its joints"
        below = " and ".join(f"'{names[other]}'" for other in others)
        more = f", and {len(pairs) - 1} more like this" if len(pairs) > 1 else ""
        words = f"the margin is zero: '{names[block]}' stands exactly {where} with {below}"
        return f"{words}{more}; the least push overturns it"

    @cached_property
    def corners_needed(self) -> str:
        """What carries more torsion than pressure spread over its face does, in words; or empty.

        Nothing needs its corners where spread pressure was tried as well, and holds it. Where it
        was not tried, other forces may carry the same load without them.
        """
        if self.force is None:
            return ""
        tried = self.samples.tried > 2 and not self.stopped
        pressure = Sensitivity.PRESSURE in self.sensitive_to
        if tried and not pressure:
            return ""
        joints = self.contacts.joints
        found, used = by_joint(self.contacts, self.resultants, self.utilisation)
        turned = np.where(np.isfinite(used), used, 0.0) > 1.0 + ACCURATE
        if not turned.any():
            return ""
        loaded = turned & _loaded(found)  # as in the table, those that carry little come last
        at = int(np.argmax(np.where(loaded if loaded.any() else turned, used, -1.0)))
        names = self.assembly.names
        pair = f"'{names[joints.block_a[at]]}' and '{names[joints.block_b[at]]}'"
        needs = "needs its corners:" if pressure else "may need its corners: with these forces"
        words = f"the joint of {pair} {needs} it turns with {100.0 * used[at]:.0f} % of what"
        return (
            f"{words} pressure spread over its face carries ('needs its corners' in the glossary)"
        )

    def tables(self) -> Sequence[Table]:
        """What gives way with its props, the joints that carry most, reactions, applied loads."""
        told = (self._props(), self.most_loaded(), self._ties(), self._reactions(), self.loads())
        return [table for table in told if len(table)]

    def layers(self) -> Scene:
        """What falls and how it begins, or the forces inside."""
        stage, facts = self.stage(), self.asked.facts()
        rubbing = f", and the loads {self._rubbing}" if self._rubbing else ""
        facts |= {"Safety": self._safety + rubbing} if self._safety else {}
        if self.stable and len(self.model) > MARGINS:
            facts |= {"Safety": "drystone limit tilt and drystone limit friction tell its margins"}
        title = f"drystone: {stage.headline.lower()}"
        return Scene(self.assembly, self.contacts, (stage,), title, facts)

    def stage(self, label: str = "result") -> SceneStage:
        """The same as one stage of a picture."""
        return stage_of(self, self.title, label)

    def numbers(self) -> Mapping[str, Any]:
        """The verdict, what it is made of, and how well the conditions are met."""
        return {
            "verdict": self.verdict,
            "method": self.method,
            "message": self.message,
            "sensitive": self.sensitive,
            "sensitive_to": self.sensitive_to,
            "settlement": [
                {
                    "carrier": path.carrier,
                    "tangential": path.tangential,
                    "outcome": path.outcome,
                    "travel": path.travel.max(),
                    "beyond": path.beyond,
                }
                for path in getattr(self.settlement, "paths", ())
            ],
            "tilt_margin": self.tilt_margin,
            "tilt_about": self.tilt_about,
            "friction_margin": self.friction_margin,
            "strength_use": float(self.strength_use.max(initial=0.0)) or None,
            "crushing_factor": self.crushing_factor,
            "falling": self.falling_names,
            "samples": self.samples,
            "residuals": self.residuals,
        }

    def _props(self) -> Table:
        """What falls, neediest first, with the missing force, and moment about the centroid."""
        prop = np.zeros((len(self.assembly), 6)) if self.prop is None else self.prop
        size = lengths(prop[:, :3])
        order = sorted(self.falling, key=lambda i: -size[i])
        force, moment = prop[order, :3], prop[order, 3:]
        arm = float(self.assembly.size.max())  # a moment that is small beside it is rounding
        seen = lengths(moment) > SAME * arm * size[order]
        moment = np.where(seen[:, None], moment, 0.0)
        columns: dict[str, Any] = {"block": [self.assembly.names[i] for i in order]}
        if self.prop is None:
            return Table("gives way", columns)
        columns |= {"missing_force": force, "missing_moment": moment}
        return Table("gives way", columns, {"missing_force": "N", "missing_moment": "N m"})

    def _reactions(self) -> Table:
        return Table("reactions", {"support": []}) if self.force is None else reaction_table(self)

    def most_loaded(self) -> Table:
        """The joints with the largest normal force and with most of the friction used.

        What a joint that carries hardly anything uses of its friction says nothing, nor does
        rounding. More than all is told only where it may need its corners.
        """
        if self.force is None or not self.force.any():
            return Table("most loaded", {"joint": []})
        names, contacts = self.assembly.names, self.contacts.joints
        found, used = by_joint(self.contacts, self.resultants, self.utilisation)
        told = np.where(_loaded(found), used, -1.0)
        heaviest, most = int(np.argmax(found.normal)), int(np.argmax(told))
        alike = told[heaviest] >= (1.0 - 1e-3) * told[most]  # of two that are alike one is told
        most = heaviest if alike else most
        at = np.array([heaviest, most] if used[most] > SAME else [heaviest])
        normal, tangential = found.normal[at], found.tangential[at]
        columns = {
            "joint": ["largest force", "most friction used"][: len(at)],
            "interface": at,
            "block_a": [names[i] for i in contacts.block_a[at]],
            "block_b": [names[i] for i in contacts.block_b[at]],
            "normal": normal,
            "tangential": np.where(tangential > SAME * np.abs(normal), tangential, 0.0),
            "friction_used": used[at] if self.corners_needed else np.minimum(used[at], 1.0),
        }
        units = {"normal": "N", "tangential": "N", "friction_used": "1"}
        return Table("most loaded", columns, units)

    def _ties(self) -> Table:
        """The pull of each tie, and the one at which it yields."""
        ties, names = np.flatnonzero(self.contacts.ties), self.assembly.names
        if self.force is None or not len(ties):
            return Table("ties", {"block_a": []})
        others = zip(self.contacts.block_a[ties], self.contacts.of_fill[ties], strict=True)
        columns = {
            "block_a": [names[i] for i in self.contacts.block_b[ties]],
            "block_b": ["(fill)" if fill else names[i] for i, fill in others],
            "pull": self.resultants.normal[ties],
            "strength": self.contacts.tie_strength[ties],
            "strength_use": self.strength_use[ties],
        }
        return Table("ties", columns, {"pull": "N", "strength": "N", "strength_use": "1"})

    @property
    def sensitive(self) -> bool:
        """Whether it stands only for some contact stiffnesses, or only after settling.

        ``sensitive_to`` has what it depends on.
        """
        some = self.samples.standing < self.samples.tried or bool(self.sensitive_to)
        return self.stable and (some or self.settlement is not None)

    def __bool__(self) -> bool:
        raise TypeError("a result is neither true nor false; ask for .stable, .falls or .verdict")

    @property
    def stable(self) -> bool:
        """Whether it was shown to stand."""
        return self.verdict is Verdict.STABLE

    @property
    def falls(self) -> bool:
        """Whether it was shown to fall."""
        return self.verdict is Verdict.UNSTABLE

    def loads(self) -> Table:
        """What is applied beside a common acceleration: load, block, point, force and moment.

        Columns
        -------
        load
            As it was asked for; ``other loads`` are those of which wrenches alone are known.
        block
        point [m]
            Where the force acts: as given, else where its line enters the block.
        force [N]
        moment [N m]
            About the point.
        """
        return loads_apart(self.assembly, self.load).table(self.assembly.names)

    def reactions(self) -> Table:
        """What each support gives to the free blocks on it; one row per support that touches one.

        Columns
        -------
        support
        point [m]
            The middle of its corners of contact, weighted by the normal forces on them.
        force [N]
            The sum of the forces on free blocks, world axes.
        moment [N m]
            On free blocks, about the point.

        Raises
        ------
        InputError
            There are no forces.

        Examples
        --------
        >>> import drystone
        >>> from drystone.models import tower
        >>> found = drystone.check(tower(2)).reactions()
        >>> found["support"].tolist(), found["force"][:, 2].round(1).tolist()
        (['block-0'], [23544.0])
        """
        self._require_forces()
        return reaction_table(self)

    def joints(self) -> Table:
        """Forces, utilisation, eccentricity and pressure of every joint.

        All facets of a curved joint are one joint; see :attr:`drystone.Contacts.joint`.

        Returns
        -------
        Table
            One row per joint.

        Columns
        -------
        joint, block_a, block_b
            Number of the joint, names of its blocks.
        area [m2]
        normal [N]
            Positive in compression.
        tangential [N]
        torque [N m]
            About the normal, on block b, at the centre of pressure.
        friction_use
            Force and torque in the plane by what friction resists under a linear pressure: 1
            slides, more needs the corners.
        eccentricity [m]
            Distance of the centre of pressure from the centroid of the joint.
        kern_ratio
            The same as a share of the distance to the rim of the kern: above 1 the joint opens.
        edge_ratio
            The same as a share of the distance to the rim of the joint: 1 is a hinge.
        mean_pressure, peak_pressure [Pa]
            The peak is that of a linear pressure that does not pull; infinite on the rim.
        strength_use
            Normal force by what a stress block around the centre of pressure carries: 1 crushes.
            Of a joint of several facets that of the worst. 0 where joints have no strength.
        force_x, force_y, force_z [N]
            Resultant on block b, world axes.
        x, y, z [m]
            Centre of pressure; the centroid where nothing presses.

        Raises
        ------
        InputError
            There are no forces.

        Examples
        --------
        >>> import drystone
        >>> from drystone.models import tower
        >>> table = drystone.check(tower(2)).joints()
        >>> table["mean_pressure"].round(1).tolist(), table["peak_pressure"].round(1).tolist()
        ([23544.0], [23544.0])
        """
        return self._joint_table

    @cached_property
    def _joint_table(self) -> Table:
        self._require_forces()
        names, found = self.assembly.names, (self.resultants, self.utilisation)
        return joint_table(self.contacts, names, *found, self.strength_use)

    def corners(self) -> Table:
        """The force at every corner of contact, in the order and the frames of ``force``.

        Returns
        -------
        Table
            One row per corner; those of one interface follow each other.

        Columns
        -------
        joint
            As in :meth:`joints`.
        interface
            Position in ``contacts``.
        block_a, block_b
            Names.
        point [m]
        n, u, v
            The frame of the interface, world axes; n points from block a to block b.
        force_n, force_u, force_v [N]
            On block b; n is positive in compression.
        area [m2]
            The part of the interface that belongs to the corner; 0 where it is a line.
        pressure [Pa]
            Normal force by that area; 0 without area.

        Raises
        ------
        InputError
            There are no forces.

        Examples
        --------
        >>> import drystone
        >>> from drystone.models import tower
        >>> table = drystone.check(tower(2)).corners()
        >>> len(table), table["force_n"].round(1).tolist(), table["pressure"][0].round(1)
        (4, [5886.0, 5886.0, 5886.0, 5886.0], np.float64(23544.0))
        """
        self._require_forces()
        contacts, names = self.contacts, np.array(self.assembly.names, dtype=object)
        of = contacts.interface
        columns = {
            "joint": contacts.joint[of],
            "interface": of,
            "block_a": names[contacts.block_a[of]],
            "block_b": names[contacts.block_b[of]],
            "point": contacts.point,
            **{axis: contacts.frame[of, i] for i, axis in enumerate("nuv")},
            **{f"force_{axis}": self._local_force[:, i] for i, axis in enumerate("nuv")},
            "area": np.where(contacts.area[of] > 0.0, contacts.tributary, 0.0),
            "pressure": corner_pressure(contacts, self._local_force),
        }
        units = {"point": "m", "area": "m2", "pressure": "Pa"}
        return Table("corners", columns, units | {f"force_{axis}": "N" for axis in "nuv"})

    def thrust_line(self, blocks: Blocks | None = None) -> ThrustLine:
        """The polyline through the centres of pressure of successive joints.

        Parameters
        ----------
        blocks
            Voussoirs in order, by name or position. Left out, the model must be one chain.

        Raises
        ------
        InputError
            There are no forces, successive blocks do not touch, or there is no single chain.
        """
        self._require_forces()
        return thrust_line(self.assembly, self.contacts, self.resultants, blocks)

    def _require_forces(self) -> None:
        if self.force is None:
            raise InputError(
                "the result has no forces", remedy="ask for those of a structure that stands"
            )


def _loaded(found: Resultants) -> Any:
    """Joints (m,) that carry more than hardly anything."""
    return found.normal > FAINT * found.normal.max(initial=0.0)
