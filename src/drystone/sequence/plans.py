"""A plan: what it says of itself."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer import Answer, Question, Role, Scene, Sentence
from drystone.base.display import differing, first_of, named, rounded_up
from drystone.base.errors import counted
from drystone.base.table import Table
from drystone.results import Verdict
from drystone.sequence.plan_layers import step_stages, summary_stage, with_robots
from drystone.sequence.plan_steps import (
    PlannedSteps,
    Prop,
    Status,
    Step,
    assigned,
    permanent_words,
)
from drystone.sequence.robots import FAR
from drystone.sequence.rules import NO_WAY, TOO_HEAVY, WAITS, Order, Rules, strength, too_heavy
from drystone.sequence.stage_tree import Node
from drystone.sequence.stages import StageAnswer, members

_REASONS = 3
"""Steps whose need of help, or margin of zero, is told in sentences; the numbers have all."""

_SILENT = (
    "with", "robot", "insertion", "hold_force", "prop_force", "prop_set", "prop_goes",
    "propped_now", "margin",
)  # fmt: skip
_COLUMNS = ("step", "block", "status", *_SILENT[:-1], "friction_used", "margin")
"""Of the table of a plan, and those that are hidden where they say nothing."""

_KINDS = FAR, TOO_HEAVY, NO_WAY, WAITS
"""How the reasons begin for which blocks cannot be placed, those that wait for others last."""


def _kind(why: str) -> str:
    """Of the reason for which a block cannot be placed."""
    return next((one for one in _KINDS if why.startswith(one)), NO_WAY)


_FORCES = "; forces were not compared: another order may need smaller ones"


@dataclass(frozen=True, eq=False)
class Plan(PlannedSteps, Answer):
    """An order of assembly.

    Attributes
    ----------
    model, steps, impossible
        See :class:`drystone.sequence.plan_steps.PlannedSteps`.
    complete
        Answer of the complete structure, without props.
    message
        Text for the user.
    proved
        Whether no other order needs less help: fewer propped blocks; with equally many fewer held
        blocks; with equally many of both more steps. Hands let go at the end of each step. Orders
        that leave a block without contact although another removal is possible are not counted.
    solved
        Number of checks of connected parts; ``solve_s`` is their total time.
    reached
        Where it stopped: the stage with the fewest blocks that it knew to stand. ``ends_with`` is
        the way from there.
    rules
        Of the search.
    """

    complete: StageAnswer = field(kw_only=True)
    message: str = ""
    proved: bool = False
    solved: int = 0
    solve_s: float = 0.0
    reached: Node | None = None
    rules: Rules = field(default_factory=Rules)

    def _summary(self) -> str:
        counts = ", ".join(f"{n} {kind}" for kind, n in self.counts.items() if n)
        told = f", {counts}" if counts else ""
        return f"{self.verdict}, {counted(len(self.steps), 'step')}{told}, '{self.message}'"

    def __bool__(self) -> bool:
        raise TypeError("a plan is neither true nor false; ask for its counts or its verdict")

    def __len__(self) -> int:
        """Number of steps."""
        return len(self.steps)

    def __iter__(self) -> Iterator[Step]:
        return iter(self.steps)

    @property
    def verdict(self) -> Verdict:
        """Verdict on the plan: STABLE if every stage stands, with the props of the plan.

        UNDECIDED if the search was stopped before it found an order, or if blocks cannot be placed.
        """
        if not self.steps and self.stopped:
            return Verdict.UNDECIDED
        answers = [a for step in self.steps for a in (*step.during, step.answer)]
        answers = answers or [self.complete]
        known = Verdict.UNDECIDED if self.impossible else Verdict.STABLE
        return next((a.verdict for a in answers if not a.stands), known)

    @property
    def stable(self) -> bool:
        """Whether every stage stands, with the props of the plan."""
        return self.verdict is Verdict.STABLE

    @property
    def ends_with(self) -> list[dict[str, list[str]]]:
        """The last steps, where the search was stopped before it knew the first ones.

        Of each step its ``blocks``, and those ``propped`` when it begins. The stages stand; less
        help was not looked for.
        """
        if self.reached is None:
            return []
        names = self.model.assembly.names
        return [
            {
                "blocks": [names[b] for b in node.group[::-1]],
                "propped": [names[b] for b in members(node.props)],
            }
            for node in self.reached.path()[:0:-1]
        ]

    @cached_property
    def asked(self) -> Question:
        """What was asked."""
        asked = Question.of(self.model.model, self.rules, self.when)
        if not self.rules.robots:
            return asked
        names = ", ".join(robot.name for robot in self.rules.robots)
        return replace(asked, options={**asked.options, "robots": names})

    @property
    def notes(self) -> tuple[str, ...]:
        """Which blocks cannot be placed, why, and the remedy; blocks with the same reason share it.

        What no robot can do comes first: other blocks may wait for it.

        Examples
        --------
        >>> from drystone.models import tower
        >>> from drystone.sequence import PlanOptions, Robot, Rules, plan
        >>> rules = Rules(robots=[Robot("arm", payload=2000.0)])
        >>> print(plan(tower(3), options=PlanOptions(rules=rules)).notes[0].partition(";")[0])
        payload 2000 kg: block-1, block-2 weigh up to 2400 kg
        """
        groups: dict[str, list[int]] = {}
        for block, why in self.impossible.items():
            groups.setdefault(why.partition(":")[0], []).append(block)
        kinds = sorted(groups, key=lambda one: _KINDS.index(_kind(one)))
        return tuple(self._why_impossible(why, groups[why]) for why in kinds)

    def _why_impossible(self, why: str, blocks: list[int]) -> str:
        """Of blocks with the same reason, as it begins; of what is out of reach the farthest."""
        if why == TOO_HEAVY:
            return too_heavy(self.rules, self.model, blocks)
        assembly, one = self.model.assembly, blocks[0]
        if why == FAR:
            short = [arm.distance(assembly.centroid) - arm.reach for arm in self.rules.robots]
            one = max(blocks, key=lambda b: float(np.min(short, axis=0)[b]))
        names = named([assembly.names[b] for b in blocks])
        return f"impossible: {names}: {self.impossible[one]}"

    @property
    def title(self) -> str:
        """Whether it can be assembled, and with which help."""
        if self.impossible:
            why = Counter(_kind(one) for one in self.impossible.values())
            known = ", ".join(f"{why[one]} {one}" for one in _KINDS if why[one])
            return f"{counted(len(self.impossible), 'block')} cannot be placed: {known}"
        if not self.steps:
            return "No plan"
        if self.verdict is not Verdict.STABLE:
            return "Not every stage is known to stand"
        counts = self.counts
        kinds = [kind for kind in ("propped", "held") if counts[kind]]
        told = [f"{counted(counts[kind], 'block')} {kind}" for kind in kinds]
        said = " and ".join(filter(None, [*told, permanent_words(self.model, self.step_of)]))
        words = f"Can be assembled {f'with {said}' if said else 'without help'}"
        return f"{words}{self._edge}"

    @property
    def _edge(self) -> str:
        return f", {counted(len(self.on_edge), 'step')} without margin" if self.on_edge else ""

    @property
    def role(self) -> Role:
        """Of its first sentence and of the title of its pictures: good where it needs no prop."""
        if not self.counts["propped"] and self.verdict is Verdict.STABLE:
            return Role.GOOD
        return Role.BAD if self.impossible else Role.UNSURE

    def sentences(self) -> Sequence[Sentence]:
        """Steps and counts, why there is no plan, and why steps need help."""
        if not self.steps:
            why = self.notes or [self.message]
            return [Sentence("NO PLAN", Role.BAD), *map(Sentence, why)]
        said = [Sentence(self.told, self.role), Sentence(self.message), *self._less_help()]
        said += [Sentence(self._lifted), Sentence(permanent_words(self.model, self.step_of))]
        if self.impossible:
            first = Sentence(self.title, Role.BAD)
            said = [first, *map(Sentence, self.notes), Sentence(self.told), *said[1:]]
        why = [f"step {i}, {one.why}" for i, one in enumerate(self.steps, 1) if one.why]
        edge = [f"after step {i + 1} {words}" for i, words in self.on_edge.items()]
        told = first_of(why, "more steps with help", _REASONS)
        told += first_of(edge, "more steps without margin", _REASONS)
        return [one for one in (*said, *map(Sentence, told)) if one.text]

    @property
    def _lifted(self) -> str:
        """Which blocks are too heavy for one hand, and how many carry each; else empty."""
        lifters, mass = strength(self.rules, self.model)[0], self.model.assembly.mass
        heavy = [b for b in self.step_of if lifters[b] > 1]
        if not heavy:
            return ""
        names = named([self.model.assembly.names[b] for b in heavy])
        most = f"{rounded_up(float(mass[heavy].max())):g} kg, payload {self.rules.payload:g} kg"
        up = "up to " if lifters[heavy].min() < lifters[heavy].max() else ""
        return f"{up}{lifters[heavy].max()} hands carry one block: {names}; up to {most}"

    def _less_help(self) -> list[Sentence]:
        """Whether another order needs less help, or how to look for one."""
        if not any(self.help) or (self.impossible and not self.proved):
            return []
        if self.proved:
            words = "no order has fewer blocks propped or held, of hands that let go after each"
            return [Sentence(f"{words} step{_FORCES if self.props else ''}")]
        tried = "course" if self.rules.order is Order.TOP else "top"
        best = "" if "patience" in self.asked.options else ", or --best, which takes longer"
        words = "another order may have fewer blocks propped or held"
        return [Sentence(f"{words}: --order {tried}{best}")]

    def tables(self) -> Sequence[Table]:
        """The blocks in the order of assembly, or those that are known to be placed last."""
        if self.steps or not self.ends_with:
            return [self.table()] if self.steps else []
        last = self.ends_with
        columns = {key: [" ".join(one[key]) for one in last] for key in ("blocks", "propped")}
        return [Table("placed last", columns)]

    def numbers(self) -> Mapping[str, Any]:
        """Plain values: counts, order, steps, blocks, props."""
        names = self.model.assembly.names
        return {
            "verdict": self.verdict,
            "complete": self.complete.verdict,
            "message": self.message,
            "notes": self.notes,
            "proved": self.proved,
            "counts": self.counts,
            "drop_m": self.drop,
            "hands": self.hands,
            "order": self.order,
            "steps": [self._step(i) for i in range(len(self.steps))],
            "blocks": [
                {
                    "block": names[b],
                    "status": self.status[b].value,
                    "step": self.step_of[b] + 1 if b in self.step_of else None,
                    "partners": [names[p] for p in self.partners(b)],
                    "why": self._why(b),
                }
                for b in range(len(names))
                if self.steps or b in self.impossible
            ],
            "props": [
                {
                    "block": names[prop.block],
                    "first_step": prop.first + 1,
                    "last_step": prop.last + 1,
                    "stages": prop.stages,
                    "at": self.model.assembly.centroid[prop.block],
                    "force": prop.wrench[:3],
                    "moment": prop.wrench[3:],
                }
                for prop in self.props
            ],
            "ends_with": self.ends_with,
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
            "step": number + 1,
            "blocks": [names[b] for b in step.blocks],
            "status": [self.status[b].value for b in step.blocks],
            "motion": step.motion,
            "directions": self.directions(number),
            "propped": [names[b] for b in step.props],
            "verdict": step.answer.verdict,
            "settled": step.answer.settled,
            "why": step.why,
            "friction_used": step.answer.used,
            "on_edge": self.on_edge.get(number, ""),
        }

    def table(self) -> Table:
        """A row per block in the order of assembly.

        Its step, status, partners, the robot that places or holds it, the direction in which it
        comes in where that is not down, the largest force of the hand that holds it for a partner,
        that of its prop, the step in which this is set and the one that ends with its removal (0:
        it stays), how many props stand, the friction used after the step, and whether the margin is
        zero then. Columns that say nothing are hidden.
        """
        team = self.rules.robots
        robot = {b: team[k].name for b, k in assigned(self, team).items()}
        prop = {one.block: one for one in self.props}
        rows = [self._row(b, robot.get(b, ""), prop.get(b)) for b in self.step_of]
        columns = {key: [row[i] for row in rows] for i, key in enumerate(_COLUMNS)}
        tells = {**columns, "prop_goes": columns["prop_set"]}  # of a prop that stays it is 0
        silent = [key for key in _SILENT if not any(tells[key])]
        units = {"hold_force": "N", "prop_force": "N"}
        return Table("assembly plan", columns, units, hidden=silent)

    def _row(self, block: int, robot: str, prop: Prop | None) -> tuple[Any, ...]:
        number, names = self.step_of[block], self.model.assembly.names
        step, partners = self.steps[number], " ".join(names[p] for p in self.partners(block))
        way = step.motion[step.blocks.index(block)]
        aside = way @ self.model.up > 1e-6 - 1.0
        insertion = ", ".join(f"{x:g}" for x in way.round(2) + 0.0) if aside else ""
        return (
            number + 1, names[block], self.status[block].value, partners, robot, insertion,
            float(np.linalg.norm(step.hold(block)[:3])), prop.force if prop else 0.0,
            prop.first + 1 if prop else None, (prop.last + 2) % (len(self) + 1) if prop else None,
            len(step.props), step.answer.used, "zero" if number in self.on_edge else "",
        )  # fmt: skip

    def layers(self) -> Scene:
        """A stage for every block that is placed; the last shows the status of all.

        A page opens with the last one, whose headline is the answer of the whole plan.
        """
        model = self.model
        number = np.array([self.step_of.get(b, -1) + 1 for b in range(len(model.assembly))])
        last = summary_stage(self, self.title, self.message, self.role)
        stages = with_robots(self, self.rules.robots, [*step_stages(self), last])
        return Scene(
            model.assembly, model.contacts, tuple(stages), f"drystone plan: {self.told}",
            {**self.asked.facts(), "Plan": self.told}, number, still=-1, opens=-1,
            preset="stages" if len(stages) > 1 else "solid",
        )  # fmt: skip
