"""What a plan says of itself: in words, tables, and block by block in pictures."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, SceneStage, Sentence, State
from drystone.answer.drawing import help_layer, interface_layers
from drystone.answer.question import directions
from drystone.base.arrays import Floats, Ints
from drystone.base.display import differing
from drystone.base.errors import counted
from drystone.base.table import Table
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.results.stage import force_layers
from drystone.sequence.plan_steps import Prop, Status, Step
from drystone.sequence.rules import Rules
from drystone.sequence.stages import StageAnswer, members
from drystone.sequence.structure import Structure

_REASONS = 3
"""Steps whose need of help is explained in sentences; the numbers have all."""
_MOST_ARROWS = 200_000
"""Largest number of arrows in all stages; with more, stages have no forces. Chosen: the page
stays below 20 MB."""

_INSERTED = 1.0
"""Length of the path of insertion that is shown, by the size of the block; chosen by eye."""

_STATE_OF = {
    Status.SUPPORT: State.SUPPORT,
    Status.IMPOSSIBLE: State.SUPPORT,
    Status.FREE: State.FREE,
    Status.HELD: State.HELD,
    Status.PROPPED: State.PROPPED,
}


class PlanAnswer(Answer):
    """The words, tables and pictures of a plan; its steps are those of the class below."""

    model: Structure  # type: ignore[assignment]  # it has the blocks and contacts of a model
    complete: StageAnswer
    steps: tuple[Step, ...]
    impossible: Mapping[int, str]
    message: str
    proved: bool
    solved: int
    solve_s: float
    stopped: str
    rules: Rules

    @property
    @abstractmethod
    def verdict(self) -> Verdict:
        """Of the plan."""

    @property
    @abstractmethod
    def props(self) -> tuple[Prop, ...]:
        """All props."""

    @property
    @abstractmethod
    def status(self) -> tuple[Status, ...]:
        """Of each block."""

    @property
    @abstractmethod
    def step_of(self) -> Mapping[int, int]:
        """Step that places each block."""

    @property
    @abstractmethod
    def order(self) -> tuple[str, ...]:
        """Names in the order of assembly."""

    @property
    @abstractmethod
    def counts(self) -> dict[str, int]:
        """Number of blocks of each status."""

    @property
    @abstractmethod
    def help(self) -> tuple[int, int, int]:
        """Number of propped and held blocks, and of placements at once."""

    @property
    @abstractmethod
    def drop(self) -> float:
        """Sum of the descents from one placement to the next."""

    @abstractmethod
    def partners(self, block: int) -> tuple[int, ...]:
        """Blocks that are placed together with this one."""

    @abstractmethod
    def directions(self, number: int) -> tuple[Floats, ...]:
        """Directions in which each block of a step can be inserted."""

    @cached_property
    def asked(self) -> Question:
        """What was asked."""
        return Question.of(self.model.model, self.rules, self.when)

    @property
    def title(self) -> str:
        """Whether it can be assembled, and with which help."""
        counts = self.counts
        if not self.steps:
            return "No plan"
        if counts["impossible"]:
            return f"No way in was found for {counted(counts['impossible'], 'block')}"
        if self.verdict is not Verdict.STABLE:
            return "Not every stage is known to stand"
        kinds = [kind for kind in ("propped", "held") if counts[kind]]
        said = " and ".join(f"{counted(counts[kind], 'block')} {kind}" for kind in kinds)
        return f"Can be assembled {f'with {said}' if said else 'without help'}"

    def sentences(self) -> Sequence[Sentence]:
        """Steps and counts, why there is no plan, and why steps need help."""
        lost = [
            Sentence(f"impossible: {self.model.assembly.names[block]}: {why}", Role.REMARK)
            for block, why in self.impossible.items()
        ]
        if not self.steps:
            return [Sentence("NO PLAN", Role.BAD), Sentence(self.message), *lost]
        helped = self.counts["propped"] + self.counts["impossible"]
        role = Role.UNSURE if helped or self.verdict is not Verdict.STABLE else Role.GOOD
        said = [Sentence(counts_text(self), role), Sentence(self.message)]
        if any(self.help) and not self.proved:
            more = "another order may need less help; --best searches all, which may take long"
            said.append(Sentence(more))
        why = [f"step {i}, {one.why}" for i, one in enumerate(self.steps, 1) if one.why]
        said += [Sentence(one) for one in why[:_REASONS]]
        if len(why) > _REASONS:
            said.append(Sentence(f"and {counted(len(why) - _REASONS, 'more step')} with help"))
        return [*said, *lost]

    def tables(self) -> Sequence[Table]:
        """The blocks in the order of assembly."""
        return [self.table()] if self.steps else []

    def numbers(self) -> Mapping[str, Any]:
        """Plain values: counts, order, steps, blocks, props."""
        names = self.model.assembly.names
        return {
            "verdict": self.verdict,
            "complete": self.complete.verdict,
            "message": self.message,
            "proved": self.proved,
            "counts": self.counts,
            "drop_m": self.drop,
            "order": self.order,
            "steps": [self._step(i) for i in range(len(self.steps))],
            "blocks": [
                {
                    "block": names[b],
                    "status": self.status[b].value,
                    "step": self.step_of.get(b),
                    "partners": [names[p] for p in self.partners(b)],
                    "why": self._why(b),
                }
                for b in range(len(names))
                if self.steps or b in self.impossible
            ],
            "props": [
                {
                    "block": names[prop.block],
                    "first_step": prop.first,
                    "last_step": prop.last,
                    "stages": prop.stages,
                    "at": self.model.assembly.centroid[prop.block],
                    "force": prop.wrench[:3],
                    "moment": prop.wrench[3:],
                }
                for prop in self.props
            ],
            "stopped": self.stopped,
            "rules": differing(self.rules),
            "checks": self.solved,
            "solve_s": self.solve_s,
        }

    def _why(self, block: int) -> str:
        """Why a block cannot be inserted, or needs help."""
        if block in self.impossible:
            return self.impossible[block]
        step = self.step_of.get(block)
        return "" if step is None or self.status[block] is Status.FREE else self.steps[step].why

    def _step(self, number: int) -> dict[str, Any]:
        step = self.steps[number]
        names = self.model.assembly.names
        return {
            "step": number,
            "blocks": [names[b] for b in step.blocks],
            "status": [self.status[b].value for b in step.blocks],
            "motion": step.motion,
            "directions": self.directions(number),
            "propped": [names[b] for b in step.props],
            "verdict": step.answer.verdict,
            "settled": step.answer.settled,
            "why": step.why,
            "friction_used": step.answer.used,
        }

    def table(self) -> Table:
        """A row per block in the order of assembly: stage, status, partners, prop, friction."""
        names = self.model.assembly.names
        prop = {one.block: one for one in self.props}
        placed = [(i, step, b) for i, step in enumerate(self.steps) for b in step.blocks]
        columns = {
            "stage": [number + 1 for number, _, _ in placed],
            "block": [names[b] for *_, b in placed],
            "status": [self.status[b].value for *_, b in placed],
            "with": [" ".join(names[p] for p in self.partners(b)) for *_, b in placed],
            "prop_force": [prop[b].force if b in prop else 0.0 for *_, b in placed],
            "prop_stages": [prop[b].stages if b in prop else 0 for *_, b in placed],
            "propped_now": [len(step.props) for _, step, _ in placed],
            "friction_used": [step.answer.used for _, step, _ in placed],
        }
        return Table("assembly plan", columns, {"prop_force": "N"})

    def layers(self) -> Scene:
        """A stage for every block that is placed; the last shows the status of all.

        A page opens with the last one, whose headline is the answer of the whole plan. The block
        that is placed moves along its path. Orange blocks are held by a hand, vermilion ones are
        propped at that stage, hatched ones will be propped later.
        """
        model = self.model
        arrows = sum(len(a.corner) for step in self.steps for a in (*step.during, step.answer))
        forces = arrows <= _MOST_ARROWS
        stages = [one for i in range(len(self.steps)) for one in _stages(self, i, forces)]
        stages.append(summary_stage(self))
        number = np.zeros(len(model.assembly), dtype=np.intp)
        for block, position in block_numbers(self).items():
            number[block] = position
        counts = counts_text(self)
        return Scene(
            model.assembly, model.contacts, tuple(stages), f"drystone plan: {counts}",
            {**self.asked.facts(), "Plan": counts}, number, still=-1, opens=-1,
            preset="stages" if len(stages) > 1 else "solid",
        )  # fmt: skip


def block_numbers(plan: PlanAnswer) -> dict[int, int]:
    """The number of each planned block, from 1 in the order of assembly."""
    order = [block for step in plan.steps for block in step.blocks]
    return {block: number for number, block in enumerate(order, 1)}


def _stages(plan: PlanAnswer, number: int, forces: bool) -> list[SceneStage]:
    """One stage for each block of a step."""
    step = plan.steps[number]
    names = plan.model.assembly.names
    numbers, count = block_numbers(plan), sum(len(one.blocks) for one in plan.steps)
    placed = step.placed & ~sum(1 << b for b in step.blocks)
    out = []
    for k, (block, answer) in enumerate(zip(step.blocks, (*step.during, step.answer), strict=True)):
        placed |= 1 << block
        held = step.blocks[: k + 1] if k < len(step.during) else ()
        parts = [f"step {number + 1} of the {len(plan.steps)} of the plan"]
        if held:
            parts.append(f"{', '.join(names[b] for b in held)} held while the next is placed")
        elif len(step.blocks) > 1:
            parts.append(f"stands together with {', '.join(names[b] for b in step.blocks[:k])}")
        if step.props:
            parts.append(f"propped: {', '.join(names[b] for b in step.props)}")
        state = _state(plan, placed, number, held)
        if state[block] in (State.FREE, State.LATER):
            state[block] = State.COMING
        here = f"block {numbers[block]} of {count}"
        label = f"{here}, {names[block]} (step {number + 1} of {len(plan.steps)})"
        stage = _stage(plan, label, "; ".join(parts), state, answer, forces)
        told = f"{here.capitalize()}: {stage.headline[0].lower()}{stage.headline[1:]}"
        stage = replace(stage, headline=told)
        out.append(replace(stage, motion=_way_in(plan, block, step.motion[k])))
    return out


def _way_in(plan: PlanAnswer, block: int, direction: Floats) -> Floats:
    """The motion (n, 6) that takes a block out of its place: the path of insertion, backwards."""
    motion = np.zeros((len(plan.model.assembly), 6))
    motion[block, :3] = -_INSERTED * plan.model.assembly.size[block] * direction
    return motion


def _state(plan: PlanAnswer, placed: int, number: int, held: tuple[int, ...]) -> Ints:
    """State (n,) of the blocks at the end of a step."""
    state = np.full(len(plan.model.assembly), State.ABSENT, dtype=np.intp)
    for block in members(placed):
        state[block] = _STATE_OF[plan.status[block]]
    for prop in plan.props:
        if placed >> prop.block & 1:
            state[prop.block] = State.LATER if prop.first > number else State.FREE
    state[state == State.HELD] = State.FREE  # a hand lets go when its step has ended
    state[[b for b in held if placed >> b & 1]] = State.HELD
    state[[b for b in plan.steps[number].props if placed >> b & 1]] = State.PROPPED
    state[plan.model.assembly.fixed] = State.SUPPORT
    return state


def _stage(
    plan: PlanAnswer, label: str, message: str, state: Ints, answer: StageAnswer, forces: bool
) -> SceneStage:
    model = plan.model
    here = state != State.ABSENT
    contacts = model.contacts
    shown = here[contacts.block_a] & here[contacts.block_b]
    prop = np.zeros((len(model.assembly), 6))
    for block, wrench in answer.reaction.items():
        prop[block] = wrench
    up, gravity = directions(model.assembly, model.model.load)
    help_needed = help_layer(model.assembly, prop, "props and hands")
    stage = SceneStage(
        label, _sentence(answer, state), message, state, answer.verdict,
        motion_name="Insertion", arrives=True, prop=prop, up=up, gravity=gravity,
        layers=interface_layers(contacts, shown) + help_needed,
    )  # fmt: skip
    if not forces or not len(answer.corner):
        return stage
    force = np.zeros((contacts.corner_count, 3))
    force[answer.corner] = answer.force
    asked = Model(model.assembly, contacts, model.model.load)
    whole = Result("plan", answer.verdict, asked, force=force)
    resultants = whole.resultants
    return replace(
        stage, force=force, normal=resultants.normal, tangential=resultants.tangential,
        utilisation=whole.utilisation, pressure_centre=resultants.position,
        layers=stage.layers + force_layers(whole, shown),
    )  # fmt: skip


def _sentence(answer: StageAnswer, state: Ints) -> str:
    """The props and hands of a stage."""
    if not answer.stands:
        return "Not known to stand" if answer.verdict is Verdict.UNDECIDED else "Falls"
    propped, held = int((state == State.PROPPED).sum()), int((state == State.HELD).sum())
    helped = [counted(propped, "prop")] if propped else []
    helped += [f"a hand on {counted(held, 'block')}"] if held else []
    return f"Stands with {' and '.join(helped)}" if helped else "Stands without help"


def summary_stage(plan: PlanAnswer) -> SceneStage:
    """The complete structure, each block in the colour of its status."""
    state = np.array([_STATE_OF[one] for one in plan.status], dtype=np.intp)
    impossible = [plan.model.assembly.names[b] for b in plan.impossible]
    message = plan.message
    if impossible:
        message += f"; cannot be inserted: {', '.join(impossible)}"
    layers = interface_layers(plan.model.contacts)
    verdict = plan.verdict
    up, gravity = directions(plan.model.assembly, plan.model.model.load)
    return SceneStage(
        f"all blocks, after {counted(len(plan.steps), 'step')}",
        plan.title,
        message,
        state,
        verdict,
        up=up,
        gravity=gravity,
        layers=layers,
    )


def counts_text(plan: PlanAnswer) -> str:
    """The number of steps, and of blocks of each status."""
    counts = plan.counts
    kinds = ("free", "held", "propped", "impossible")
    said = ", ".join(f"{counts[k]} {k}" for k in kinds if counts[k] or k != "impossible")
    return f"{len(plan.steps)} steps: {said}"
