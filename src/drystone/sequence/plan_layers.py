"""A plan block by block in pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from drystone.answer import Layer, LayerKind, MarkerShape, Role, SceneStage, State
from drystone.answer.drawing import help_layer, interface_layers, load_layers
from drystone.answer.question import directions
from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.display import named
from drystone.base.errors import counted
from drystone.base.ragged import Ragged
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.results.stage import force_layers
from drystone.sequence.plan_steps import PlannedSteps, Status, assigned, permanent
from drystone.sequence.robots import Robot
from drystone.sequence.rules import WAITS
from drystone.sequence.scaffold_seats import post_ways
from drystone.sequence.stages import StageAnswer, StagedModel, members

_MOST_ARROWS = 200_000
"""Largest number of arrows in all stages; with more, stages have no forces. Chosen: the page
stays below 20 MB."""

_INSERTED = 1.0
"""Length of the path of insertion that is shown, by the size of the block; chosen by eye."""

_STATE_OF = {
    Status.SUPPORT: State.SUPPORT,
    Status.IMPOSSIBLE: State.ABSENT,
    Status.FREE: State.FREE,
    Status.UNSURE: State.FREE,
    Status.HELD: State.HELD,
    Status.PROPPED: State.PROPPED,
}


def step_stages(plan: PlannedSteps) -> list[SceneStage]:
    """A stage for every block that is placed, which moves along its path.

    Orange blocks are held by a hand, vermilion ones are propped at that stage, hatched ones will be
    propped later.
    """
    arrows = sum(len(a.corner) for step in plan.steps for a in (*step.during, step.answer))
    forces = arrows <= _MOST_ARROWS
    return [stage for i in range(len(plan.steps)) for stage in _of_step(plan, i, forces)]


def _of_step(plan: PlannedSteps, number: int, forces: bool) -> list[SceneStage]:
    """One stage for each block of a step."""
    step = plan.steps[number]
    names = plan.model.assembly.names
    here, placed = f"step {number + 1} of {len(plan.steps)}", plan.before(number)
    out = []
    for k, (block, answer) in enumerate(zip(step.blocks, (*step.during, step.answer), strict=True)):
        placed |= 1 << block
        held = step.blocks[: k + 1] if k < len(step.during) else ()
        parts = []
        if held:
            parts.append(f"{', '.join(names[b] for b in held)} held while the next is placed")
        elif len(step.blocks) > 1:
            parts.append(f"stands together with {', '.join(names[b] for b in step.blocks[:k])}")
        state = _state(plan, placed, number, held)
        if (propped := np.flatnonzero(state == State.PROPPED)).size:
            parts.append(f"propped: {', '.join(names[b] for b in propped)}")
        if state[block] in (State.FREE, State.LATER):
            state[block] = State.COMING
        state[[b for b in answer.falling if state[b] != State.SUPPORT]] = State.FALLING
        said = "; ".join(parts)
        stage = stage_of(plan.model, f"{here}: {names[block]}", said, state, answer, forces)
        told = f"{here.capitalize()}: {stage.headline[0].lower()}{stage.headline[1:]}"
        out.append(replace(stage, headline=told, motion=_way_in(plan, block, step.motion[k])))
    whole = filter(None, [out[-1].message, plan.on_edge.get(number)])
    return [*out[:-1], replace(out[-1], message="; ".join(whole))]


def _way_in(plan: PlannedSteps, block: int, direction: Floats) -> Floats:
    """The motion (n, 6) that takes a block out of its place: the path of insertion, backwards."""
    motion = np.zeros((len(plan.model.assembly), 6))
    motion[block, :3] = -_INSERTED * plan.model.assembly.size[block] * direction
    return motion


def _state(plan: PlannedSteps, placed: int, number: int, held: tuple[int, ...]) -> Ints:
    """State (n,) of the blocks in a step; props of the step before stay while a hand holds."""
    state = np.full(len(plan.model.assembly), State.ABSENT, dtype=np.intp)
    for block in members(placed):
        state[block] = _STATE_OF[plan.status[block]]
    for prop in plan.props:
        if placed >> prop.block & 1:
            state[prop.block] = State.LATER if prop.first > number else State.FREE
    state[state == State.HELD] = State.FREE  # a hand lets go when its step has ended
    state[list(held)] = State.HELD
    late = plan.steps[max(0, number - bool(held)) : number + 1]
    state[[b for step in late for b in step.props if placed >> b & 1]] = State.PROPPED
    state[plan.model.assembly.fixed] = State.SUPPORT
    return state


def stage_of(
    model: StagedModel, label: str, message: str, state: Ints, answer: StageAnswer, forces: bool
) -> SceneStage:
    """A stage of a model whose blocks have these states (n,), with its forces if asked."""
    here = state != State.ABSENT
    contacts = model.contacts
    shown = here[contacts.block_a] & here[contacts.block_b]
    prop = np.zeros((len(model.assembly), 6))
    for block, wrench in answer.reaction.items():
        prop[block] = wrench
    up, gravity = directions(model.assembly, model.model.load)
    help_needed = help_layer(model.assembly, prop, "props and hands")
    stage = SceneStage(
        label, _sentence(answer, state), message, state, Role.of(answer.verdict),
        motion_name="Insertion", arrives=True, prop=prop, up=up, gravity=gravity,
        layers=interface_layers(contacts, shown) + help_needed,
    )  # fmt: skip
    return with_forces(stage, model, answer, shown) if forces else stage


def with_forces(
    stage: SceneStage, model: StagedModel, answer: StageAnswer, shown: Bools
) -> SceneStage:
    """A stage with the forces of an answer, where it has some, at the interfaces shown (m,)."""
    if not len(answer.corner):
        return stage
    contacts = model.contacts
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


def summary_stage(plan: PlannedSteps, title: str, message: str, role: Role) -> SceneStage:
    """The complete structure in the colours of the statuses, with the forces of the last step.

    What it warns of has its edges drawn.
    """
    state = np.array([_STATE_OF[one] for one in plan.status], dtype=np.intp)
    waiting = [b for b, why in plan.impossible.items() if why.startswith(WAITS)]
    missing = [b for b in plan.impossible if b not in waiting]
    unsure = [b for step in plan.steps if not step.answer.stands for b in step.blocks]
    assembly = plan.model.assembly
    if missing:
        message += f"; cannot be placed: {named([assembly.names[b] for b in missing])}"
    here, contacts = state != State.ABSENT, plan.model.contacts
    shown = here[contacts.block_a] & here[contacts.block_b]
    up, gravity = directions(assembly, plan.model.load)
    stage = SceneStage(
        f"all blocks, after {counted(len(plan.steps), 'step')}", title, message, state, role,
        up=up, gravity=gravity,
        layers=(
            *interface_layers(contacts, shown),
            *load_layers(assembly, plan.model.load),
            *outlined(assembly, waiting, "waiting", "waits for what cannot be placed"),
            *outlined(assembly, missing, "left-out", "cannot be placed", "help"),
            *outlined(assembly, unsure, "unsure", "not shown to stand when placed"),
        ),
    )  # fmt: skip
    return with_forces(stage, plan.model, plan.steps[-1].answer, shown) if plan.steps else stage


def with_robots(
    plan: PlannedSteps, team: Sequence[Robot], stages: Sequence[SceneStage]
) -> list[SceneStage]:
    """Stages, one for each block that is placed and then others, with the robots of a team.

    A mark is the base of a robot, a line leads from it to the block that it places or holds, and
    arcs show where its reach ends.
    """
    arms = {block: team[k] for block, k in assigned(plan, team).items()}
    seen = [step.blocks[: k + 1] for step in plan.steps for k in range(len(step.blocks))]
    assembly = plan.model.assembly
    out = [with_arms(assembly, arms, *one) for one in zip(seen, stages, strict=False)]
    others = [replace(one, message="; ".join([one.message, *_shares(plan, arms)]))
              for one in stages[len(out) :]]  # fmt: skip
    return with_reach(plan.model, team, [*out, *others])


def _posts(model: StagedModel) -> tuple[Layer, ...]:
    """Props that are fixed blocks, as posts."""
    at, prop, carried = permanent(model)
    if not len(at):
        return ()
    contacts, start = model.contacts, model.contacts.centroid[at]
    way = np.where(contacts.block_a[at] == prop, -1.0, 1.0)[:, None] * contacts.frame[at, 0]
    label = f"{counted(len(at), 'prop')}, there from the beginning"
    along = post_ways(model.assembly, carried, start, way)
    return (Layer("posts", label, LayerKind.LINES, "help", start, along, width=4.0),)


def _shares(plan: PlannedSteps, arms: Mapping[int, Robot]) -> list[str]:
    """The steps of each robot."""
    steps: dict[str, list[str]] = {}
    for block in sorted(arms, key=lambda b: plan.step_of[b]):
        steps.setdefault(arms[block].name, []).append(str(plan.step_of[block] + 1))
    return [f"'{name}' at steps {named(own)}" for name, own in steps.items()]


def with_reach(
    model: StagedModel, team: Sequence[Robot], stages: Sequence[SceneStage]
) -> list[SceneStage]:
    """Stages with permanent props, the bases of a team, and arcs where its reach ends."""
    around = _posts(model) + (_robot_layers(model.assembly, team) if team else ())
    return [replace(one, layers=one.layers + around) for one in stages]


def with_arms(
    assembly: Assembly, arms: Mapping[int, Robot], blocks: Sequence[int], stage: SceneStage
) -> SceneStage:
    """A stage with lines from robots to the blocks of its step, of which the last is placed."""
    busy = [(b, arms[b]) for b in reversed(blocks) if b in arms]
    if not busy:
        return stage
    names, start = assembly.names, np.array([arm.base for _, arm in busy])
    way = assembly.centroid[[b for b, _ in busy]] - start
    doing = [f"'{arm.name}' {'places' if b == blocks[-1] else 'holds'} {names[b]}"
             for b, arm in busy]  # fmt: skip
    layer = Layer("arms", ", ".join(doing), LayerKind.LINES, "load", start, way, width=2.0)
    message = "; ".join([*doing, *filter(None, [stage.message])])
    return replace(stage, message=message, layers=(*stage.layers, layer))


def _robot_layers(assembly: Assembly, team: Sequence[Robot]) -> tuple[Layer, ...]:
    """The bases of robots, and the edges of their reach in the middle plane of the blocks."""
    base, names = np.array([one.base for one in team]), tuple(one.name for one in team)
    bases = Layer("robots", "base of a robot", LayerKind.MARKERS, "load", base, text=names)
    bases = replace(bases, shape=MarkerShape.DIAMOND)
    low = np.minimum(assembly.bounds[:, 0].min(axis=0), base.min(axis=0))
    high = np.maximum(assembly.bounds[:, 1].max(axis=0), base.max(axis=0))
    past = 0.1 * float(np.linalg.norm(high - low)) * np.array([1.0, 1.0, 1e-3])  # not below ground
    angle = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
    free = assembly.centroid[assembly.free]
    middle = 0.5 * (free.min(axis=0) + free.max(axis=0))
    normal = min((1, 0, 2), key=lambda axis: round(float(np.ptp(free[:, axis])), 9))
    start, way, text, told = [base[:0]], [base[:0]], list[str](), [np.full(3, np.inf)]
    for one in team:
        aside = middle[normal] - one.base[normal]
        radius = np.sqrt(max(one.reach**2 - aside**2, 0.0))
        if 0.0 < radius < np.inf:
            ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            edge = one.base + np.insert(ring, normal, aside, axis=1)
            near = np.flatnonzero(((edge >= low - past) & (edge < high + past[0])).all(axis=1))
            # what leaves the picture and comes back within half a circle is drawn
            gap = np.diff(np.append(near, near[:1] + len(edge)))
            part = [
                np.arange(i, i + k) for i, k in zip(near, gap, strict=True) if 2 * k <= len(edge)
            ]
            first = np.concatenate([near[:0], *part]) % len(edge)
            then = (first + 1) % len(edge)
            above = np.minimum(edge[first, 2], edge[then, 2]) >= low[2] - past[2]
            first, then = first[above], then[above]
            start.append(edge[first])
            way.append(edge[then] - edge[first])
            text += _written(f"reach of {one.name}", edge[first], told, float(past[0]))
    if not text:
        return (bases,)
    label, line = "where a reach ends, in the middle plane of the blocks", LayerKind.LINES
    parts = np.concatenate(start), np.concatenate(way)
    return bases, Layer("reach", label, line, "reaction", *parts, text=tuple(text))


def _written(name: str, points: Floats, told: list[Floats], apart: float) -> list[str]:
    """A name at the highest of points (p, 3) so far from those ``told``, or at the farthest."""
    text = [""] * len(points)
    if text:
        away = np.min([np.linalg.norm(points - one, axis=1) for one in told], axis=0)
        at = int(np.argmax(np.where(away >= min(apart, away.max()), points[:, 2], -np.inf)))
        told.append(points[at])
        text[at] = name
    return text


def outlined(
    assembly: Assembly, blocks: Sequence[int], key: str, label: str, ink: str = "missed"
) -> tuple[Layer, ...]:
    """The edges of blocks that a plan warns of, where they are or would be."""
    if not blocks:
        return ()
    faces = assembly.faces
    rings, corner = Ragged.over(faces.start), faces.point[faces.loop]
    here = np.isin(rings.spread(faces.owner), blocks)
    way = (corner[rings.following] - corner)[here]
    return (Layer(key, label, LayerKind.LINES, ink, corner[here], way, width=2.0),)
