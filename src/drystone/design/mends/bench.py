"""Changes of one region, each with the least value at which its local model stands."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from drystone.base.arrays import Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.design.causes.diagnosed import Region
from drystone.design.causes.diagnosis_words import names_of, newtons, place
from drystone.design.causes.missing import HEAVIEST, ROUGHEST, ballasted
from drystone.design.causes.prop_forces import least_prop, propped
from drystone.design.causes.regions import interfaces_of, local_model
from drystone.design.mends.margin import DesignMargin
from drystone.design.surgery.block_surgery import merge_blocks, thicken_blocks
from drystone.design.surgery.joint_changes import (
    Change,
    change_of,
    joint_width,
    with_block,
    words_of,
)
from drystone.design.surgery.struts import struts
from drystone.model import Model

TURNS = (5.0, 15.0, 35.0)
"""[degrees] Rotations that are tried before the least one is searched."""

SHARPNESSES = (5.0, 10.0, 25.0, 45.0)
"""[degrees] The same for wedges. A very small wedge locks rigid blocks, but not real ones, so none
below the first value is tried."""

DEPTHS = (0.1, 0.25, 0.5, 1.0)
"""The same for blocks that are let into each other, relative to the width of the joint; none below
the first value, for the same reason."""

THICKER = (0.1, 0.3, 1.0)
"""The same for the increase of thickness, relative to that of the block."""

MANY = 4
"""Largest number of blocks of a region with which every joint and every block is tried alone.
Chosen. In a larger region all joints, or all blocks, are changed together."""

STRUTS = 6
"""Number of struts of one block that are tried, the shortest first."""

KINDS = (
    "support", "prop", "friction", "turn", "wedge", "let-in", "thicker", "ballast", "glue",
)  # fmt: skip
"""The kinds of mends."""


@dataclass(frozen=True, eq=False)
class Candidate(OneLine):
    """A change that holds a region in its local model.

    Attributes
    ----------
    kind
        One of :data:`KINDS`.
    words
        The change as text, from its value.
    value
        The least value that was found.
    make
        The change, from its value.
    joints
        Number of joints that are touched.
    added
        Number of things that are added.
    most, close
        Largest value that may be tried, and the accuracy of the least one; zero if there is nothing
        to vary.
    """

    kind: str
    words: Callable[[float], str]
    value: float
    make: Callable[[float], Change]
    joints: int = 0
    added: int = 0
    most: float = 0.0
    close: float = 0.0

    @classmethod
    def single(
        cls, kind: str, words: str, value: float, make: Change, joints: int = 0, added: int = 0
    ) -> Candidate:
        """A change with nothing to vary."""
        return cls(kind, lambda _: words, value, lambda _: make, joints, added)


@dataclass(frozen=True)
class Tried(OneLine):
    """A kind of mend that does not hold a region.

    Attributes
    ----------
    kind
    what
        What was tried, and how far.
    """

    kind: str
    what: str


class Bench:
    """Search for the mends of one region.

    Parameters
    ----------
    model
    motion : (n, 6)
        First motion of its blocks.
    region
    margin
    keep
        Positions of blocks that may not be changed.
    """

    def __init__(
        self,
        model: Model,
        motion: Floats,
        region: Region,
        margin: DesignMargin,
        keep: frozenset[int],
    ) -> None:
        self.model = model
        self.region = region
        self.margin = margin
        self.local, self.blocks = local_model(self.model, region.blocks)
        self.interfaces: Ints = np.flatnonzero(interfaces_of(self.model, region.blocks))
        self.motion = motion
        self.keep = keep
        self.tried: list[Tried] = []
        self.own = list(range(len(region.blocks)))

    def stands(self, make: Change) -> bool:
        """Whether the local model stands after a change; False if the change is impossible."""
        here = np.arange(len(self.blocks)), np.arange(len(self.interfaces))
        try:
            changed = make(self.local, *here)
        except InputError:
            return False
        return self.margin.meets(self.margin.holds(changed, quick=True))

    def least(
        self,
        make: Callable[[float], Change],
        steps: Sequence[float],
        width: float,
        low: float = 0.0,
    ) -> float | None:
        """The least value of a change with which the local model stands, to an accuracy.

        No value below ``low`` is tried.
        """
        for high in steps:
            if self.stands(make(high)):
                while high - low > width:
                    middle = 0.5 * (low + high)
                    if self.stands(make(middle)):
                        high = middle
                    else:
                        low = middle
                return high
            low = high
        return None

    def may_change(self, interface: int) -> bool:
        """Whether both blocks at an interface of the local model may be changed."""
        contacts = self.local.contacts
        ends = (contacts.block_a[interface], contacts.block_b[interface])
        return not any(int(self.blocks[end]) in self.keep for end in ends)

    def joint_name(self, interface: int) -> str:
        """A joint as text: lower, upper or inner, and the other block."""
        contacts, count = self.local.contacts, len(self.own)
        a, b = int(contacts.block_a[interface]), int(contacts.block_b[interface])
        if a < count and b < count:
            return f"the joint of {names_of(self.local, [a, b])}"
        own, other = (a, b) if a < count else (b, a)
        above = contacts.centroid[interface][2] > self.local.assembly.centroid[own][2]
        return f"the {'upper' if above else 'lower'} joint, with {names_of(self.local, [other])},"

    def candidates(self, kinds: Sequence[str]) -> Iterator[Candidate]:
        """The changes that hold the region in its local model, of these kinds."""
        makers: dict[str, Callable[[], Iterator[Candidate]]] = {
            "support": self._support,
            "prop": self._prop,
            "friction": self._friction,
            "turn": partial(self._joints, "turn"),
            "wedge": partial(self._joints, "wedge"),
            "let-in": partial(self._joints, "let-in"),
            "thicker": self._thicker,
            "ballast": self._ballast,
            "glue": self._glue,
        }
        for kind in kinds:
            yield from makers[kind]()

    def _fail(self, kind: str, what: str) -> None:
        self.tried.append(Tried(kind, what))

    def _support(self) -> Iterator[Candidate]:
        if len(self.own) > MANY:
            self._fail("support", f"not tried on a region of more than {MANY} blocks")
            return
        number = 0
        for i in self.own:
            whole = self.region.blocks[i]
            for strut in struts(self.model, whole, self.motion[whole])[:STRUTS]:
                number += 1

                make = partial(with_block, strut.body)
                if strut.on in self.blocks:
                    stands = self.stands(make)
                else:  # it stands on a block that the region does not touch
                    wide = self.model.subset([*self.blocks.tolist(), strut.on])
                    wide = wide.with_supports(list(range(len(self.own), len(wide))))
                    result = self.margin.holds(with_block(strut.body, wide), quick=True)
                    stands = self.margin.meets(result)
                if stands:
                    on = names_of(self.model, [strut.on])
                    size = strut.body.volume
                    yield Candidate.single(
                        "support",
                        f"a block of {size:.3g} m3, {strut.length:.3g} m long, between {on} and "
                        f"{names_of(self.model, [whole])}",
                        strut.length,
                        make,
                        joints=0,
                        added=1,
                    )
                    return
        self._fail("support", f"{number} blocks that fit were tried, the shortest first")

    def _prop(self) -> Iterator[Candidate]:
        held = least_prop(self.local, self.own[:MANY], self.motion[self.blocks])
        if held is None:
            self._fail("prop", "no single prop on a free face holds it")
            return
        seat, force = held

        def make(model: Model, blocks: Ints, _: Ints) -> Model:
            return propped(model, replace(seat, block=int(blocks[seat.block])))[0]

        if self.stands(make):
            name = names_of(self.local, [seat.block])
            yield Candidate.single(
                "prop",
                f"a prop of {newtons(force.size)} against {name} at {place(force.point)}",
                force.size,
                make,
                added=1,
            )
        else:
            self._fail("prop", "the best single prop does not keep the margin")

    def _friction(self) -> Iterator[Candidate]:
        own = self.local.contacts.friction
        count = len(own)
        groups = [[k] for k in range(count)] if len(self.own) <= MANY else []
        found = False
        for group in [*groups, *([list(range(count))] if groups != [[0]] else [])]:
            if found and len(group) > 1:
                return

            def make(value: float, group: list[int] = group) -> Change:
                def rough(model: Model, _: Ints, interfaces: Ints) -> Model:
                    friction = np.array(model.contacts.friction)
                    at = interfaces[group]
                    friction[at] = np.maximum(friction[at], value)
                    return model.with_friction(friction)

                return rough

            low = float(own[group].min())
            steps = [x for x in (1.0, 2.0, ROUGHEST) if x > low]
            value = self.least(make, steps, 0.01)
            if value is not None:
                found = True
                where = "in all its joints" if len(group) > 1 else f"in {self.joint_name(group[0])}"
                yield Candidate(
                    "friction",
                    partial(_friction_words, where),
                    value,
                    make,
                    joints=len(group),
                    most=ROUGHEST,
                    close=0.01,
                )
        if not found:
            self._fail(
                "friction", f"it falls up to a coefficient of {ROUGHEST:g} in all its joints"
            )

    def _joints(self, kind: str) -> Iterator[Candidate]:
        """Joints rotated, made wedges or let in: each one in a small region, else all together."""
        count = len(self.interfaces)
        groups = [[k] for k in range(count)] if len(self.own) <= MANY else [list(range(count))]
        for group in groups:
            name = self.joint_name(group[0]) if len(group) == 1 else "all its joints"
            if not all(self.may_change(k) for k in group):
                self._fail(kind, f"{name.rstrip(',')} may not be changed")
                continue
            try:
                width = min(joint_width(self.local, k) for k in group)
            except InputError as error:
                self._fail(kind, str(error))
                continue
            steps, close = {
                "turn": (TURNS, 0.05),
                "wedge": (SHARPNESSES, 0.25),
                "let-in": (tuple(share * width for share in DEPTHS), 0.01 * width),
            }[kind]
            best: tuple[float, Callable[[float], Change]] | None = None
            for side in (1.0, -1.0):
                make = partial(change_of, kind, group, side)
                within = [x for x in steps if best is None or x < best[0]]
                if best is not None:
                    within.append(best[0] - close)
                value = self.least(make, within, close, steps[0] if kind != "turn" else 0.0)
                if value is not None:
                    best = value, make
            most = f"{steps[-1]:g} degrees" if kind != "let-in" else f"{1e3 * steps[-1]:.0f} mm"
            if best is None:
                self._fail(kind, f"{name.rstrip(',')} up to {most}")
                continue
            yield Candidate(
                kind, words_of(kind, name), best[0], best[1], joints=len(group),
                most=steps[-1], close=close,
            )  # fmt: skip

    def _thicker(self) -> Iterator[Candidate]:
        if any(i in self.keep for i in self.region.blocks):
            self._fail("thicker", "its blocks may not be changed")
            return

        def make(share: float) -> Change:
            def thick(model: Model, blocks: Ints, _: Ints) -> Model:
                return thicken_blocks(model, blocks[self.own].tolist(), share)

            return thick

        value = self.least(make, THICKER, 0.02)
        if value is None:
            self._fail("thicker", f"up to {100.0 * THICKER[-1]:g} % more thickness")
            return
        them = names_of(self.model, self.region.blocks)
        yield Candidate(
            "thicker", lambda x: f"{them} thicker by {100.0 * x:.0f} %", value, make,
            most=THICKER[-1], close=0.02,
        )  # fmt: skip

    def _ballast(self) -> Iterator[Candidate]:
        ballast = self.region.needs.ballast
        if ballast is None:
            what = f"no weight up to {HEAVIEST:g} times its own on one block holds it"
            self._fail("ballast", what)
            return
        at = self.region.blocks.index(ballast.block)

        def make(model: Model, blocks: Ints, _: Ints) -> Model:
            return ballasted(model, int(blocks[at]), ballast.force)

        if self.stands(make):
            name = names_of(self.model, [ballast.block])
            yield Candidate.single(
                "ballast", f"a weight of {newtons(ballast.force)} on {name}", ballast.force, make,
                added=1,
            )  # fmt: skip
        else:
            self._fail("ballast", "the least weight does not keep the margin")

    def _glue(self) -> Iterator[Candidate]:
        if len(self.own) > MANY:
            self._fail("glue", f"not tried on a region of more than {MANY} blocks")
            return
        contacts = self.local.contacts
        pulls = {pull.interface: pull.force for pull in self.region.needs.pulls}
        pairs = dict.fromkeys(
            zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
        )
        found = False
        for a, b in pairs:
            if {int(self.blocks[a]), int(self.blocks[b])} & self.keep:
                continue
            fixed = self.local.assembly.fixed
            first, second = (a, b) if fixed[a] or not fixed[b] else (b, a)

            def make(
                model: Model, blocks: Ints, _: Ints, one: int = first, two: int = second
            ) -> Model:
                return merge_blocks(model, int(blocks[one]), int(blocks[two]))

            if self.stands(make):
                found = True
                own = [k for k in range(contacts.count) if {int(contacts.block_a[k]),
                       int(contacts.block_b[k])} == {a, b}]  # fmt: skip
                pull = sum(pulls.get(int(self.interfaces[k]), 0.0) for k in own)
                strength = f" that can pull {newtons(pull)}" if pull > 0.0 else ""
                yield Candidate.single(
                    "glue", f"glue{strength} between {names_of(self.local, [a, b])}", pull, make,
                    joints=len(own),
                )  # fmt: skip
        if not found:
            self._fail("glue", "it falls with any one of its joints glued")


def _friction_words(where: str, value: float) -> str:
    return f"friction of {value:.2f} {where}".rstrip(",")


def volume_changed(before: Model, after: Model) -> float:
    """Volume [m3] of the differences between equally named blocks, and of other blocks."""
    old = dict(zip(before.assembly.names, before.assembly.volume.tolist(), strict=True))
    new = dict(zip(after.assembly.names, after.assembly.volume.tolist(), strict=True))
    names = set(old) | set(new)
    return float(sum(abs(new.get(name, 0.0) - old.get(name, 0.0)) for name in names))


__all__ = ["KINDS", "Bench", "Candidate", "Tried", "volume_changed"]
