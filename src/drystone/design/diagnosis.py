"""Diagnosis: falling blocks, their first motion, and missing forces.

The diagnosis of a structure that falls: its regions, as text and as plain values.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Unpack

import numpy as np

from drystone.answer import Answer, Layer, LayerKind, Role, Scene, Sentence
from drystone.base.arrays import SAME, Floats, frozen, lengths, marked
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, Options, Stopped, checked_call
from drystone.checks import first_motion_of, moving_joints
from drystone.design import words
from drystone.design.bench import Bench
from drystone.design.changes import ROUGHEST
from drystone.design.joint_motion import JointState, joint_states, sentence
from drystone.design.margin import LARGE_REGION, soon_at_rest
from drystone.design.needs import (
    NEEDED,
    Needs,
    one_force,
    pulls_of,
    refuse_other_kinds,
    search_needs,
)
from drystone.design.props import posts
from drystone.design.regions import (
    interfaces_of,
    local_model,
    regions_of,
    solve_alone,
    with_wrenches,
)
from drystone.formulations.nearest_mechanism import nearest_mechanism
from drystone.io.opening import Given, LongHow, as_model
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.stability import check
from drystone.stability.problem import Problem, sound_mechanism


@dataclass(frozen=True)
class DiagnosisOptions(Options):
    """Options of :func:`diagnose`.

    Attributes
    ----------
    regions : >= 1
        Number of regions that are examined, the heaviest first.
    kinds
        What is searched of that with which each region stands: prop, friction, ballast, turn and
        glue (all). With none the diagnosis has the falling blocks, their motion and the missing
        force only.
    large
        Whether what regions of more than 40 blocks need is searched too: each trial is slow there.
    """

    regions: int = 20
    kinds: tuple[str, ...] = NEEDED
    large: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_other_kinds(self.kinds, NEEDED, "need")

    @classmethod
    def brief(cls) -> DiagnosisOptions:
        """Why the three heaviest regions fall, without what they need."""
        return cls(kinds=(), regions=3)


@checked_call
def diagnose(
    given: Given,
    *,
    options: DiagnosisOptions | None = None,
    result: Result | None = None,
    **how: Unpack[LongHow],
) -> Diagnosis:
    """Why a model falls, and what would hold it.

    Falling blocks that touch each other form a region. Each region is examined alone, with its
    neighbours fixed: its first motion, the joints that carry nothing, slide or are hinges, and the
    least prop, friction, ballast and glue with which it stands.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    options
    result
        A result of a check of this model, if available.

    Returns
    -------
    Diagnosis

    Raises
    ------
    InputError
        What was given cannot be made into a model, or the result is of another one.

    Examples
    --------
    >>> from drystone.models import h_model
    >>> found = diagnose(h_model(), friction=0.9)
    >>> for part in found.reasons[0].replace(", or", ";or").split(";"):
    ...     print(part.strip())
    block 'block' slides down along 'left' and 'right'
    nothing presses on it
    a support that gives 33.9 kN (up) at (0, 0, -0.2) m
    or the joint with 'right' turned by 1 degrees
    or glue between 'left' and 'block' that carries a pull, and a shear, of 15 kN would hold it
    """
    chosen = DiagnosisOptions.of(options)
    clock = Clock.of(how)
    model = as_model(given, **how)
    if result is not None and result.model is not model:
        raise InputError("the result is of another model", remedy="leave it out")
    clock.tell("check", 0, 2)
    answer = check(model, stop=clock.late) if result is None else result
    if answer.stable:
        return Diagnosis(answer, (), frozen(np.zeros((len(model), 6))))
    answer = with_wrenches(answer, clock.late, clock.left_s)
    prop = np.zeros((len(model), 6))
    if not answer.falling:
        return Diagnosis(answer, (), frozen(prop), stopped=clock.reason)
    if answer.prop is not None:  # else forces balance, and how it settles decides
        prop[list(answer.falling)] = answer.prop[list(answer.falling)]
    groups = regions_of(model, answer.falling)
    looked = groups[: chosen.regions]
    motion = frozen(first_motion_of(model, prop))
    task = partial(_region, model, answer, prop, motion, chosen, clock)
    clock.tell("what falls", 0, len(looked))
    regions = list(clock.answers(task, looked, "what falls", least=len(looked)))
    others = tuple(i for blocks in groups[chosen.regions :] for i in blocks)
    wanted = "friction" in chosen.kinds and not others and not clock.late()
    friction = _friction_of_all(model, regions, clock.late) if wanted else None
    return Diagnosis(answer, tuple(regions), motion, friction, others, stopped=clock.reason)


def _region(
    model: Model,
    answer: Result,
    prop: Floats,
    drawn: Floats,
    options: DiagnosisOptions,
    clock: Clock,
    blocks: tuple[int, ...],
) -> Region:
    """A region, examined with its neighbours fixed."""
    late = clock.late
    interfaces = interfaces_of(model, blocks)
    local, position = local_model(model, blocks)
    large = len(blocks) > LARGE_REGION
    known = large and (len(blocks) == model.assembly.free.size or answer.mechanism is not None)
    alone = answer if known else solve_alone(local, late)
    wrench = prop[list(blocks)]
    if not known and alone.prop is not None and not alone.stable and np.any(alone.prop):
        wrench = np.array(alone.prop[: len(blocks)])
    mine = np.zeros((len(model), 6))
    mine[list(blocks)] = wrench
    motion = first_motion_of(model, mine)
    forces = answer.force if answer.force is not None else answer.force_with_props
    needy = marked(list(blocks), len(model))
    seen = np.where(needy[:, None], drawn, 0.0)
    joints = joint_states(model, needy, interfaces, seen if seen.any() else motion, forces)
    force, point = one_force(model, blocks, wrench)
    pulls = pulls_of(alone.contacts, alone.tension, np.flatnonzero(interfaces))
    needs = Needs(frozen(wrench), frozen(force), frozen(point), pulls)
    if options.kinds and (options.large or not large) and not alone.stable and not late():
        with contextlib.suppress(Stopped):
            for found in search_needs(
                Bench(model, blocks, motion, stop=late), needs, options.kinds
            ):
                needs = replace(needs, **found)
    return Region(
        blocks,
        tuple(position[len(blocks) :].tolist()),
        local,
        alone.verdict,
        joints,
        needs,
        sentence(model, blocks, joints, needs, moving_joints(model, drawn)[0])
        if wrench.any()
        else words.nothing(answer),
    )


def _friction_of_all(model: Model, regions: list[Region], late: Callable[[], bool]) -> float | None:
    """The least coefficient of all joints with which the whole model stands.

    The largest need of a region alone is a lower bound; a check of the whole model confirms it.
    """
    each = [region.needs.friction for region in regions]
    if any(value is None for value in each):
        return None
    most = max(value for value in each if value is not None)
    rough = np.maximum(model.contacts.friction, most)
    with contextlib.suppress(Stopped):
        return most if soon_at_rest(model.with_friction(rough), late).stable else None
    return None


@dataclass(frozen=True, eq=False)
class Region(OneLine):
    """Connected blocks that fall or need help.

    Attributes
    ----------
    blocks
        Positions of the blocks in the model.
    neighbours
        Positions of the blocks that touch them, which are fixed in the local model.
    local
        The model of the region alone: first its blocks (free), then its neighbours (fixed).
    verdict
        Of the local model; of the whole, where a mechanism of it has more than 40 blocks here.
    joints
        First motion of each block at each of its interfaces.
    needs
        What would hold it.
    sentence
        What happens, and what to do.
    """

    blocks: tuple[int, ...]
    neighbours: tuple[int, ...]
    local: Model
    verdict: Verdict
    joints: tuple[JointState, ...]
    needs: Needs
    sentence: str

    def _summary(self) -> str:
        return f"{counted(len(self.blocks), 'block')}, '{self.sentence}'"

    def fall_for(self, kind: str) -> Floats | None:
        """A mechanism (r, 6) [m, rad] of the local model that no friction stops, if it is known.

        It is sought for mends of friction of a large region; other kinds know it from then on: most
        glue that fails does by it as well.
        """
        sought = kind == "friction" or "_fall" in vars(self)
        return self._fall if sought and len(self.blocks) > LARGE_REGION else None

    @cached_property
    def _fall(self) -> Floats | None:
        rough = np.maximum(self.local.contacts.friction, ROUGHEST)
        problem = Problem.build(self.local.with_friction(rough))
        found = nearest_mechanism(problem.statics).motion
        return None if found is None else sound_mechanism(problem, found)


@dataclass(frozen=True, eq=False)
class Diagnosis(Answer):
    """Where a model falls, why, and which forces are missing.

    Attributes
    ----------
    result
        Result of the check, or of the penalty form if the check is undecided.
    regions
        The heaviest first; empty where it stands.
    motion : (n, 6) [m, rad]
        First motion of the blocks; the fastest one moves by about its size.
    friction
        Coefficient of all joints with which the whole model stands; ``None`` if it stands already
        or none was found.
    others
        Blocks of regions that were not examined.
    """

    result: Result
    regions: tuple[Region, ...]
    motion: Floats
    friction: float | None = None
    others: tuple[int, ...] = ()

    @property
    def model(self) -> Model:
        """The diagnosed model."""
        return self.result.model

    @property
    def reasons(self) -> tuple[str, ...]:
        """A sentence for each region, or one if the model stands."""
        if not self.regions:
            return (words.nothing(self.result),)
        said = [region.sentence for region in self.regions]
        if self.others:
            more = counted(len(self.others), "more block falls", "more blocks fall")
            said.append(f"{more}: {words.names_of(self.model, self.others)}")
        if self.friction is not None:
            regions = [region.needs.friction for region in self.regions]
            said.append(words.friction_of_all(self.friction, regions))
        return tuple(said)

    @property
    def props(self) -> tuple[Floats, Floats]:
        """Points (p, 3) [m] and forces (p, 3) [N] of the props that hold the regions."""
        return _arrows(
            [(one.point, one.force) for r in self.regions for one in r.needs.props.props]
        )

    @property
    def missing(self) -> tuple[Floats, Floats]:
        """The same of the missing force of each region that no props were found to hold."""
        bare = [region.needs for region in self.regions if not region.needs.props.props]
        least = SAME * float(lengths(self.model.load.wrench[:, :3]).max())  # else a moment is
        missing = [one for one in bare if np.linalg.norm(one.force) > least]
        return _arrows([(needs.point, needs.force) for needs in missing])

    @property
    def title(self) -> str:
        """The verdict as a plain sentence."""
        return self.result.title

    def sentences(self) -> Sequence[Sentence]:
        """The verdict, and why the heaviest regions fall."""
        verdict, *_ = self.result.sentences()
        told, regions = list(self.reasons), len(self.regions)
        if regions > 5:
            told[5:regions] = [f"and {regions - 5} more regions like these (--json lists all)"]
        said = [verdict, Sentence(self.result.message), *map(Sentence, told)]
        if self.stopped:
            said.append(Sentence(f"{self.stopped} before all was tried", Role.REMARK))
        return [one for one in said if one.text]

    def layers(self) -> Scene:
        """The model with its first motion and the forces that would hold it."""
        stage = self.result.stage("diagnosis")
        needed = self._posts()
        point, force = self.missing
        if len(point):
            needed += [Layer("missing", "forces that are missing", LayerKind.ARROWS, "help", point,
                             force, single=True, width=2.0, group="help")]  # fmt: skip
        shown = [x for x in stage.layers if x.group == "loads" or x.kind is not LayerKind.ARROWS]
        stage = replace(
            stage,
            message="; ".join(self.reasons),
            motion=self.motion if self.regions else None,
            prop=None,
            layers=(*shown, *needed),
        )
        return replace(self.result.layers(), stages=(stage,))

    def _posts(self) -> list[Layer]:
        props = [one.block for region in self.regions for one in region.needs.props.props]
        blocks = np.array(props, dtype=np.intp)
        return posts(self.model.assembly, blocks, *self.props, " that would hold it")

    def numbers(self) -> Mapping[str, Any]:
        """Of each region: its joints, and what would hold it."""
        return {
            "verdict": self.result.verdict,
            "message": self.result.message,
            "friction_of_all": self.friction,
            "others": [self.model.assembly.names[i] for i in self.others],
            "regions": [_plain_region(self.model, region) for region in self.regions],
        }


def _arrows(pairs: list[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    point, force = ([one[k] for one in pairs] for k in (0, 1))
    return np.array(point).reshape(-1, 3), np.array(force).reshape(-1, 3)


def _plain_region(model: Model, region: Region) -> dict[str, Any]:
    names, contacts, needs = model.assembly.names, model.contacts, region.needs

    def joint(k: int) -> dict[str, Any]:
        return {"interface": k, "blocks": [names[contacts.block_a[k]], names[contacts.block_b[k]]]}

    ballast, turn, blocks = needs.ballast, needs.turn, [names[i] for i in region.blocks]
    return {
        "blocks": blocks,
        "neighbours": [names[i] for i in region.neighbours],
        "verdict": region.verdict,
        "sentence": region.sentence,
        "joints": [
            {
                **vars(one),
                "block": names[one.block],
                "neighbour": names[one.neighbour],
                "motion": one.motion.name.lower(),
            }
            for one in region.joints
        ],
        "needs": {
            "prop": {"force": needs.force, "point": needs.point},
            "wrench": dict(zip(blocks, needs.wrench, strict=True)),
            "supports": [
                {"block": names[one.block], "force": one.force, "point": one.point}
                for one in needs.props.props
            ],
            "friction": needs.friction,
            "ballast": ballast and {"block": names[ballast.at[0]], "force": ballast.value},
            "turn": turn and {**joint(turn.at[0]), "degrees": turn.value, "jams": turn.jams},
            "glue": [
                {"joints": [joint(k) for k in glue.at], "strength": glue.value}
                for glue in needs.glue
            ],
            "tension": [{**vars(one), **joint(one.interface)} for one in needs.pulls],
        },
    }
