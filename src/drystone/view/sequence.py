"""A plan as a scene that plays stage by stage, and as numbered instructions on paper."""

from __future__ import annotations

import html
import io
from dataclasses import replace
from os import PathLike

import numpy as np

from drystone.arrays import Floats, Ints
from drystone.assembly import Block
from drystone.files import write_bytes
from drystone.model import Model
from drystone.results import Result
from drystone.sequence.plans import Plan, Status, Step
from drystone.sequence.stage.stages import Answer, members
from drystone.view.figure import draw
from drystone.view.palette import State
from drystone.view.scene import Scene, Stage
from drystone.view.staging import force_layers, help_layer, interface_layers

MOST_ARROWS = 200_000
"""Arrows of all stages together; beyond, stages are drawn without their forces. Chosen: the page
stays below 20 MB."""

ALIKE = 0.9
"""Cosine of the angle up to which faces are one side of a block to a reader."""

STATE_OF = {
    Status.SUPPORT: State.SUPPORT,
    Status.IMPOSSIBLE: State.SUPPORT,
    Status.FREE: State.FREE,
    Status.HELD: State.HELD,
    Status.PROPPED: State.PROPPED,
}

INSTRUCTIONS_STYLE = """
:root { color-scheme: light; }
body { font: 14px/1.45 system-ui, sans-serif; color: #1d1b18; background: #ffffff;
  max-width: 62rem; margin: 1.5rem auto; padding: 0 1rem; }
h1 { font-size: 1.25rem; margin: 0 0 .25rem; } p { margin: .25rem 0 1rem; color: #5d5950; }
svg { width: 100%; height: auto; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .2rem .6rem; border-bottom: 1px solid #d5d1c7; }
th { color: #5d5950; font-weight: 500; }
td.n, th.n { text-align: right; }
tr.held td:nth-child(3) { background: #d9d9d9; } tr.propped td:nth-child(3) { background: #1c1c1c;
  color: #ffffff; }
@media print { body { margin: 0; max-width: none; } tr { break-inside: avoid; } }
"""


def plan_scene(plan: Plan) -> Scene:
    """A scene with a stage for every step, and one while hands hold; the last shows every status.

    Light grey blocks were placed alone, dark grey ones are held or were placed together, black ones
    are propped at that stage.
    """
    model = plan.model
    arrows = sum(len(a.corner) for step in plan.steps for a in (*step.during, step.answer))
    forces = arrows <= MOST_ARROWS
    stages = [stage for i in range(len(plan.steps)) for stage in _stages(plan, i, forces)]
    stages.append(_summary(plan))
    title = f"drystone plan: {_counts(plan)}"
    return Scene(model.assembly, model.contacts, tuple(stages), title)


def save_instructions(plan: Plan, path: str | PathLike[str]) -> None:
    """Write a page for printing: the blocks, numbered in the order of assembly, and a table.

    Parameters
    ----------
    plan
    path
        Written to a temporary name beside it and renamed.
    """
    write_bytes(path, instructions_text(plan).encode("utf-8"))


def instructions_text(plan: Plan) -> str:
    """The instructions as HTML with an inline drawing."""
    head = "".join(
        f"<th{' class=n' if number else ''}>{title}</th>"
        for title, number in (
            ("no.", True), ("block", False), ("status", False), ("with", False),
            ("moved along", False), ("prop [N]", True), ("for stages", True),
            ("props in place", True),
        )
    )  # fmt: skip
    rows = "".join(_row(plan, step) for step in plan.steps)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Assembly plan</title><style>{INSTRUCTIONS_STYLE}</style></head><body>"
        f"<h1>Assembly plan</h1><p>{html.escape(_counts(plan))}. {html.escape(plan.message)}.</p>"
        f"{_numbered_drawing(plan)}"
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
        "</div></body></html>\n"
    )


def block_numbers(plan: Plan) -> dict[int, int]:
    """The number of each planned block, from 1 in the order of assembly."""
    order = [block for step in plan.steps for block in step.blocks]
    return {block: number for number, block in enumerate(order, 1)}


def _stages(plan: Plan, number: int, forces: bool) -> list[Stage]:
    step = plan.steps[number]
    names = plan.model.assembly.names
    before = step.placed & ~sum(1 << b for b in step.blocks)
    out = []
    placed = before
    count = len(plan.steps)
    for k, answer in enumerate(step.during):
        placed |= 1 << step.blocks[k]
        held = step.blocks[: k + 1]
        message = f"{', '.join(names[b] for b in held)} held while the next is placed"
        state = _state(plan, placed, step.props, held)
        label = f"step {number + 1} of {count}, holding"
        out.append(_stage(plan, label, message, state, answer, forces))
    what = " and ".join(names[b] for b in step.blocks)
    together = step.blocks if len(step.blocks) > 1 else ()
    message = f"{what} placed" + (" together" if together else "")
    if step.props:
        message += f"; propped: {', '.join(names[b] for b in step.props)}"
    state = _state(plan, step.placed, step.props, together)
    label = f"step {number + 1} of {count}"
    out.append(_stage(plan, label, message, state, step.answer, forces))
    return out


def _state(plan: Plan, placed: int, props: tuple[int, ...], held: tuple[int, ...]) -> Ints:
    state = np.full(len(plan.model.assembly), State.ABSENT, dtype=np.intp)
    for block in members(placed):
        status = plan.status[block]
        state[block] = State.FREE if status is Status.PROPPED else STATE_OF[status]
    state[[b for b in held if placed >> b & 1]] = State.HELD
    state[[b for b in props if placed >> b & 1]] = State.PROPPED
    state[plan.model.assembly.fixed] = State.SUPPORT
    return state


def _stage(
    plan: Plan, label: str, message: str, state: Ints, answer: Answer, forces: bool
) -> Stage:
    model = plan.model
    here = state != State.ABSENT
    contacts = model.contacts
    shown = here[contacts.block_a] & here[contacts.block_b]
    prop = np.zeros((len(model.assembly), 6))
    for block, wrench in answer.reaction.items():
        prop[block] = wrench
    layers = interface_layers(contacts, shown) + help_layer(model.assembly, prop, "props and hands")
    headline = "Stands" if answer.stands else answer.verdict.value.capitalize()
    if not forces or not len(answer.corner):
        return Stage(label, headline, message, state, answer.verdict, prop=prop, layers=layers)
    force = np.zeros((contacts.corner_count, 3))
    force[answer.corner] = answer.force
    whole = Result("plan", answer.verdict, Model(model.assembly, contacts, model.load), force=force)
    resultants = whole.resultants
    return Stage(
        label, headline, message, state, answer.verdict, prop=prop, force=force,
        normal=resultants.normal, tangential=resultants.tangential, utilisation=whole.utilisation,
        pressure_centre=resultants.position, layers=layers + force_layers(whole, shown),
    )  # fmt: skip


def _summary(plan: Plan) -> Stage:
    state = np.array([STATE_OF[one] for one in plan.status], dtype=np.intp)
    impossible = [plan.model.assembly.names[b] for b in plan.impossible]
    message = plan.message
    if impossible:
        message += f"; cannot be put in: {', '.join(impossible)}"
    layers = interface_layers(plan.model.contacts)
    verdict = plan.verdict
    return Stage("all steps", _counts(plan), message, state, verdict, layers=layers)


def _counts(plan: Plan) -> str:
    counts = plan.counts
    kinds = ("free", "held", "propped", "impossible")
    said = ", ".join(f"{counts[k]} {k}" for k in kinds if counts[k] or k != "impossible")
    return f"{len(plan.steps)} steps: {said}"


def _row(plan: Plan, step: Step) -> str:
    names = plan.model.assembly.names
    numbers = block_numbers(plan)
    prop = {one.block: one for one in plan.props}
    rows = []
    for block, motion in zip(step.blocks, step.motion, strict=True):
        status = plan.status[block].value
        one = prop.get(block)
        cells = (
            (str(numbers[block]), True),
            (names[block], False),
            (status, False),
            (", ".join(str(numbers[b]) for b in plan.partners(block)), False),
            (", ".join(f"{x:.2f}" for x in motion + 0.0), False),
            (f"{one.force:,.0f}" if one else "", True),
            (str(one.stages) if one else "", True),
            (str(len(step.props)) if step.props else "", True),
        )
        text = "".join(
            f"<td{' class=n' if right else ''}>{html.escape(cell)}</td>" for cell, right in cells
        )
        rows.append(f'<tr class="{status}">{text}</tr>')
    return "".join(rows)


def shown_middle(block: Block, toward: Floats) -> Floats:
    """Middle (3,) of the side of a block that an eye in some direction sees most of.

    A side is the face with the largest picture and those that turn as it does, within ALIKE.
    """
    triangles = np.array(
        [
            block.vertices[[face[0], face[i], face[i + 1]]]
            for face in block.faces
            for i in range(1, len(face) - 1)
        ]
    )
    normal = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    largest = normal[int(np.argmax(normal @ toward))]
    alike = normal @ largest > ALIKE * np.linalg.norm(normal, axis=1) * np.linalg.norm(largest)
    weight = np.where(alike, normal @ toward, 0.0)
    middle: Floats = weight @ triangles.mean(axis=1) / weight.sum()
    return middle


def _numbered_drawing(plan: Plan) -> str:
    """Inline SVG of the complete structure with a number at every planned block."""
    # what the summary says stands above the drawing
    bare = replace(_summary(plan), headline="", message="")
    scene = Scene(plan.model.assembly, plan.model.contacts, (bare,), "plan")
    figure = draw(scene, (9.0, 6.5), layers=())
    axes = figure.axes[0]
    right = np.cross([0.0, 0.0, 1.0], scene.toward)
    right /= np.linalg.norm(right)
    paper = np.stack([right, np.cross(scene.toward, right)])
    numbers = block_numbers(plan)
    for block, number in numbers.items():
        middle = shown_middle(plan.model.assembly.blocks[block], scene.toward)
        x, y = (middle - scene.centre) @ paper.T
        axes.text(
            x, y, str(number), ha="center", va="center", fontsize=7, zorder=1e6,
            bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "alpha": 0.75, "lw": 0},
        )  # fmt: skip
    text = io.StringIO()
    figure.savefig(text, format="svg")
    drawn = text.getvalue()
    return drawn[drawn.index("<svg") :]


__all__ = ["block_numbers", "instructions_text", "plan_scene", "save_instructions", "shown_middle"]
