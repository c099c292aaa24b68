"""The forces of a form of the source, and virtual interfaces in words: ``kern``, ``0.5``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, Unpack

import numpy as np

from drystone import virtual
from drystone.answer import Answer, Layer, Role, Scene, Sentence, Verdict
from drystone.answer.drawing import interface_layers
from drystone.base.arrays import Bools, Floats, Ints, lengths
from drystone.base.declared import Offered
from drystone.base.errors import InputError, counted, located
from drystone.base.settings import Progress, Stop, checked_call
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.checks import unbalanced_wrench
from drystone.contacts import Contacts
from drystone.formulations.corner_forces import FrictionCone, FrictionRule
from drystone.formulations.equilibrium import Objective, Weights
from drystone.io.opening import Given, How, as_model
from drystone.io.registry import read_file
from drystone.joints import by_joint
from drystone.model import Model
from drystone.programs.cra import HELD, PULLS, PenaltyOptions, solve_cra, solve_cra_penalty
from drystone.programs.rbe import RBEOptions, solve_rbe
from drystone.results import Result
from drystone.stability.problem import UNBALANCED

_ALONE = "Compression alone balances the loads"


_VIRTUAL = ("virtual", "virtual interfaces", "kern")
"""Key, label and colour of the layer of reduced joints."""


@dataclass(frozen=True, eq=False)
class Forces(Answer):
    """Forces in the joints, with tension where there is no other way.

    Attributes
    ----------
    form
        ``rbe``, ``cra``, ``penalty`` or ``file``.
    result
        Its contacts are the virtual ones.
    real
        The contacts of the model before some were reduced.
    threshold
        Friction coefficient that the resultant of a joint is held against, if one was given.
    """

    form: str
    result: Result
    real: Contacts
    threshold: float | None = None

    @property
    def model(self) -> Model:
        """What was asked about."""
        return self.result.model

    @cached_property
    def pull(self) -> Floats:
        """Tension [N] of each joint."""
        result, contacts = self.result, self.contacts
        if result.tension is None or result.force is None:
            return np.zeros(contacts.joints.count)
        least = self._small(result.force)
        some = np.where(result.tension > least, result.tension, 0.0)
        owner = contacts.joint[contacts.interface]
        return np.bincount(owner, some, contacts.joints.count).astype(np.float64)

    def _small(self, force: Floats) -> float:
        """What counts as no force [N]: by the largest one, or the largest load of a free block."""
        load = self.model.load.wrench[~self.assembly.fixed, :3]
        return PULLS * max(float(np.abs(one).max(initial=0.0)) for one in (force, load))

    @cached_property
    def unheld(self) -> tuple[str, ...]:
        """Names of the blocks that the penalty form does not hold: no joint of theirs opens."""
        force = self.result.force
        if self.form != "penalty" or force is None:
            return ()
        total, scale = unbalanced_wrench(self.model, force)
        loose = ~self.assembly.fixed & (lengths(total) > HELD * scale)
        return tuple(self.assembly.names[i] for i in np.flatnonzero(loose))

    @cached_property
    def friction(self) -> Floats:
        """Friction coefficient that the resultant of each joint needs; infinite where it pulls."""
        result = self.result
        found, _ = by_joint(self.contacts, result.resultants, result.utilisation)
        normal = np.maximum(found.normal, 0.0)
        small = self._small(found.force)
        rubs = np.where(found.tangential > small, found.tangential, 0.0)
        return np.divide(rubs, normal, out=np.where(rubs > 0.0, np.inf, 0.0),
                                   where=normal > small)  # fmt: skip

    @property
    def _over(self) -> Ints:
        """Joints whose friction exceeds the threshold."""
        if self.threshold is None:
            return np.zeros(0, dtype=np.intp)
        return np.flatnonzero(self.friction > self.threshold * (1.0 + PULLS))

    @property
    def _balanced(self) -> bool:
        residuals = self.result.residuals
        return residuals is None or residuals.equilibrium <= PULLS

    @property
    def title(self) -> str:
        """Whether compression alone balances the loads."""
        if self.result.force is None:
            if self.result.stopped:
                return "No forces were found in time"
            if self.form == "cra":
                return "No forces that fit a motion were found; states that jam are not searched"
            return "No forces balance the loads"
        if not self._balanced:
            return "These forces do not balance the loads"
        if self.pull.any() or self.unheld:
            return self._with_tension()
        told = _ALONE
        over = len(self._over)
        if not over:
            return told
        return f"{told}, with more friction than {self.threshold:g} in {counted(over, 'joint')}"

    def _with_tension(self) -> str:
        """How much tension is needed, and what it does not hold."""
        pulled, loose = int((self.pull > 0.0).sum()), self.unheld
        beside = f"hold {loose[0]}" if len(loose) == 1 else f"hold {len(loose)} blocks"
        if pulled:
            joints = counted(self.contacts.joints.count, "joint")
            most = quantity(float(self.pull.sum()), "N")
            told = f"Tension is needed: {most} in {pulled} of {joints}"
            return f"{told}; it does not {beside}" if loose else told
        return f"Tension in the joints does not {beside}"

    @property
    def _reduced(self) -> str:
        """Within what there are no forces, where joints were reduced."""
        reduced = self.contacts is not self.real and self.result.message == UNBALANCED
        return " within the reduced joints" if reduced else ""

    def sentences(self) -> Sequence[Sentence]:
        """Whether compression is enough, what the method said, and the friction."""
        found = self.result.force is not None
        good = self.title == _ALONE
        said = [
            Sentence(self.title, Role.GOOD if good else Role.BAD),
            Sentence(self.result.message + self._reduced),
        ]
        if self.form == "rbe":
            said.append(Sentence("forces by equilibrium alone: check says whether it stands"))
        if self.threshold is not None and found:
            most = float(self.friction.max(initial=0.0))
            told = f"{most:.4g} at most" if np.isfinite(most) else "more than any"
            said.append(
                Sentence(f"friction that joints need: {told}; threshold {self.threshold:g}")
            )
        return [one for one in said if one.text]

    def tables(self) -> Sequence[Table]:
        """The most loaded joints, those that pull, and those that need more than the threshold."""
        made = [
            self.result.most_loaded(),
            self._table("tension", np.flatnonzero(self.pull > 0.0), self.pull),
            self._table("friction", self._over, self.friction),
        ]
        return [one for one in made if len(one)]

    def _table(self, name: str, which: Ints, value: Floats) -> Table:
        """Joints by a value, the largest first."""
        order = which[np.argsort(-value[which], kind="stable")]
        names, joints = self.assembly.names, self.contacts.joints
        columns = {
            "joint": order,
            "block_a": [names[i] for i in joints.block_a[order]],
            "block_b": [names[i] for i in joints.block_b[order]],
            name: value[order],
        }
        title = "joints that pull" if name == "tension" else "joints beyond the threshold"
        return Table(title, columns, {name: "N"} if name == "tension" else {})

    def layers(self) -> Scene:
        """The forces, the tension, and the joints coloured by the threshold."""
        result = self.result
        if self.form == "rbe":  # which knows nothing of motions
            result = replace(result, verdict=Verdict.UNDECIDED, falling=(), mechanism=None)
        role = Role.of(self.result.verdict)
        stage = replace(result.stage("forces"), headline=self.title, role=role, plays=False)
        instead = {"interfaces"}
        if self.threshold is not None:
            instead |= {"joint-force", "joint-pressure", "joint-use"}
        own = tuple(one for one in stage.layers if one.key not in instead)
        reduced = self.contacts is not self.real
        shown = replace(
            stage,
            layers=(
                *interface_layers(self.real),
                *(interface_layers(self.contacts, None, *_VIRTUAL) if reduced else ()),
                *self._by_threshold(),
                *own,
            ),
        )
        title = f"drystone: {self.title.lower()}"
        return Scene(self.assembly, self.contacts, (shown,), title, self.asked.facts())

    def _by_threshold(self) -> tuple[Layer, ...]:
        if self.threshold is None or self.result.force is None:
            return ()
        over = np.isin(self.contacts.joint, self._over)
        told = f"friction {self.threshold:g}"
        return (
            *interface_layers(self.contacts, ~over, "within", f"within {told}", "missed"),
            *interface_layers(self.contacts, over, "beyond", f"beyond {told}", "help"),
        )

    def numbers(self) -> Mapping[str, Any]:
        """The form, tension and friction in all, and how well the conditions are met."""
        most = float(self.friction.max(initial=0.0))
        return {
            "form": self.form,
            "verdict": self.result.verdict,
            "tension_in_all": float(self.pull.sum()),
            "friction_needed": most,
            "threshold": self.threshold,
            "solver": self.result.solver,
            "residuals": self.result.residuals,
            "time_s": self.result.time_s,
        }


@checked_call
def find_forces(
    given: Given,
    *,
    form: Literal["rbe", "cra", "penalty", "file"] = "rbe",
    objective: Objective = Objective.QUADRATIC,
    rule: FrictionRule = FrictionRule.PLUS,
    cone: FrictionCone | None = None,
    gamma: float | None = None,
    threshold: float | None = None,
    virtual: Sequence[str] = (),
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> Forces:
    """Forces in the joints by a form of the source, with tension where there is no other way.

    Parameters
    ----------
    given
        A model; or an assembly or a file, of which ``how`` makes one.
    form
        Equilibrium alone, forces with a motion that fits them (eq. 5.6), these with tension
        (eq. 5.8), or those of a solved file: rbe, cra, penalty, file.
    objective
        What is minimised by equilibrium alone: squares, the sum, or the sum in a vertex.
    rule
        Which normal force carries friction where there is tension: the positive part or the net
        force.
    cone
        Friction cone of equilibrium alone: exact or octagon (exact, of a vertex octagon).
    gamma : > 0
        Cost of tension by that of compression (1e6; in the penalty form as far as it converges,
        1000 at most).
    threshold : coefficient >= 0, < inf
        Friction that the resultant of a joint may use: joints are coloured by it, while friction
        bounds the forces at corners.
    virtual
        Joints that are reduced: to their kern, to a share such as 0.5, or towards a side such as
        -z=0.2, in or out (of an arch or a dome); of all blocks or of those named behind an @.
    progress
        Called as ``progress(stage, done, total)``, with 0 <= done <= total.
    stop
        Called often; True ends the calculation with the results so far.
    time_limit_s
        Time [s] after which the calculation ends with the results so far.

    Returns
    -------
    Forces

    Raises
    ------
    InputError
        What was given cannot be made into a model, an option belongs to another form, or the file
        has no forces.

    Notes
    -----
    Source: Kao 2023, sections 4.2, 5.3 and 6.1.

    Examples
    --------
    >>> from drystone.models import overhang
    >>> find_forces(overhang([0.75]), friction=0.8).title
    'Tension is needed: 2.94 kN in 1 of 1 joint'
    """
    real = as_model(given, **how)
    real.require_ends_as_drawn("a look at forces")
    if form != "rbe":
        _refuse_of_rbe(objective=objective, rule=rule, cone=cone)
    if form in ("cra", "file") and gamma is not None:
        raise InputError(f"form {form} has no cost", where="gamma", remedy="ask for form penalty")
    if form == "file":
        if len(virtual):
            raise InputError(
                "is for forces that are sought", where="virtual", remedy="leave it out"
            )
        solved = _stored(real)
        return Forces(form, solved, solved.contacts, threshold)
    model = real.with_contacts(virtual_contacts(real, virtual)) if len(virtual) else real
    common: dict[str, Any] = {"progress": progress, "stop": stop, "time_limit_s": time_limit_s}
    if form == "rbe":
        options = _of_rbe(objective, rule, cone, gamma)
        result = solve_rbe(model, options=options, **common)
    elif form == "cra":
        result = solve_cra(model, **common)
    else:
        result = solve_cra_penalty(model, options=PenaltyOptions(gamma=gamma), **common)
    return Forces(form, result, real.contacts, threshold)


def _refuse_of_rbe(**given: Any) -> None:
    """Raise InputError where an option of equilibrium alone is given to another form."""
    usual = {"objective": Objective.QUADRATIC, "rule": FrictionRule.PLUS, "cone": None}
    for name, one in given.items():
        if one != usual[name]:
            raise InputError("is for form rbe", where=name, remedy="leave it out")


def _of_rbe(
    objective: Objective, rule: FrictionRule, cone: FrictionCone | None, gamma: float | None
) -> RBEOptions:
    """The options of equilibrium alone."""
    if cone is None:
        vertex = objective is Objective.VERTEX
        cone = FrictionCone.octagon() if vertex else FrictionCone.exact()
    weights = Weights() if gamma is None else Weights(tension=gamma)
    return RBEOptions(cone=cone, objective=objective, rule=rule, weights=weights)


def _stored(model: Model) -> Result:
    """The result that the file of a model has.

    Raises
    ------
    InputError
        It has none, or there is no file.
    """
    origin = model.origin
    units: Any = origin.reading.get("units")
    results = read_file(origin.file, units=units).results if origin.file else ()
    for one in results:
        if one.force is not None:
            return replace(one, model=replace(one.model, origin=origin))
    raise InputError(
        "the file has no forces",
        where=origin.file or "form",
        remedy="give a solved COMPAS assembly, or ask for another form",
    )


OFFERED = Offered(
    find_forces, "arch.json --virtual kern --threshold 0.7", ("form", "virtual"), "joints"
)

_WHERE = "virtual"


def virtual_contacts(model: Model, words: Sequence[str]) -> Contacts:
    """The contacts of a model, some of them reduced.

    Parameters
    ----------
    model
    words
        Each is ``WHAT`` or ``WHAT@BLOCKS``: the joints of one block, or those between several,
        separated by commas; ``supports`` means the joints with fixed blocks. ``WHAT`` is ``kern``,
        a share of the size from 0 (a point) to 1, or a direction, such as ``-z``, ``x=0.2``,
        ``1,0,1``, or ``in`` and ``out``, to and from the middle of the supports: the joint is
        compressed towards that side to a share of its extent, to the edge when left out.

    Raises
    ------
    InputError
        It cannot be read, or names what does not exist.

    Examples
    --------
    >>> from drystone.models import tower
    >>> made = virtual_contacts(Model.of(tower(3)), ["kern", "x=0.5@block-0"])
    >>> made.area.round(3).tolist()
    [0.028, 0.056]
    """
    made = model.contacts
    for word in [words] if isinstance(words, str) else words:
        what, _, blocks = word.partition("@")
        with located(_WHERE):
            made = _reduced(model, made, what.strip(), _joints(model, blocks.strip()))
    return made


def _joints(model: Model, blocks: str) -> Bools:
    """Which interfaces (m,) are meant."""
    contacts = model.contacts
    if not blocks:
        return np.ones(contacts.count, dtype=bool)
    fixed = model.assembly.fixed
    if blocks == "supports" and blocks not in model.assembly.names:
        return fixed[contacts.block_a] | fixed[contacts.block_b]
    which = model.assembly.indices([name.strip() for name in blocks.split(",")])
    mine = np.isin(contacts.block_a, which), np.isin(contacts.block_b, which)
    found: Bools = mine[0] & mine[1] if len(which) > 1 else mine[0] | mine[1]
    if not found.any():
        raise InputError(f"there is no joint of {blocks}", remedy="name blocks that touch")
    return found


def _reduced(model: Model, contacts: Contacts, what: str, which: Bools) -> Contacts:
    if what == "kern":
        return virtual.to_kern(contacts, which)
    direction, _, share = what.partition("=")
    try:
        towards = _direction(model, contacts, direction)
        size = float(what) if towards is None else float(share or 0.0)
    except ValueError as error:
        remedy = "write kern, a share such as 0.5, or a side such as -z=0.2 or in=0.2"
        raise InputError(f"'{what}' is no virtual interface", remedy=remedy) from error
    if towards is None:
        return virtual.shrink(contacts, size, which)
    return virtual.shift(contacts, towards, size, which)


def _direction(model: Model, contacts: Contacts, text: str) -> list[float] | Floats | None:
    """Vectors (3,) or (m, 3) of a text such as ``-z`` or ``in``; None where it is no direction."""
    if text in ("in", "out"):
        middle = model.assembly.centroid[model.assembly.fixed].mean(axis=0)
        away = virtual.section_centroids(contacts) - middle
        return -away if text == "in" else away
    if text.lstrip("+-") in ("x", "y", "z"):
        sign = -1.0 if text.startswith("-") else 1.0
        return [sign * (text[-1] == axis) for axis in "xyz"]
    return [float(one) for one in text.split(",")] if "," in text else None
