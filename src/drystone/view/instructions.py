"""A plan as numbered instructions for printing."""

from __future__ import annotations

import html
import io
from dataclasses import replace
from os import PathLike

import numpy as np

from drystone.base.display import name_text
from drystone.base.files import write_text
from drystone.sequence.plan_steps import Step
from drystone.sequence.plans import Plan
from drystone.view.figure import draw

_INSTRUCTIONS_STYLE = """
:root { color-scheme: light; }
body { font: 14px/1.45 system-ui, sans-serif; color: #1d1b18; background: #ffffff;
  max-width: 62rem; margin: 1.5rem auto; padding: 0 1rem; }
h1 { font-size: 1.25rem; margin: 0 0 .25rem; } p { margin: .25rem 0 1rem; color: #5d5950; }
svg { width: 100%; height: auto; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .2rem .6rem; border-bottom: 1px solid #d5d1c7; }
th { color: #5d5950; font-weight: 500; }
td:nth-child(2), td:nth-child(4) { overflow-wrap: anywhere; }
td:nth-child(5) { white-space: nowrap; }
td.n, th.n { text-align: right; }
tr.held td:nth-child(3) { background: #e69f00; } tr.propped td:nth-child(3) { background: #d55e00;
  color: #ffffff; }
@media print { body { margin: 0; max-width: none; } tr { break-inside: avoid; } }
"""


def save_instructions(plan: Plan, path: str | PathLike[str]) -> None:
    """Write a page for printing: the blocks with the steps that place them, and a table.

    Parameters
    ----------
    plan
    path
        Written to a temporary name beside it and renamed.
    """
    write_text(path, instructions_text(plan))


def instructions_text(plan: Plan) -> str:
    """The instructions as HTML with an inline drawing."""
    head = "".join(
        f"<th{' class=n' if number else ''}>{title}</th>"
        for title, number in (
            ("step", True), ("block", False), ("status", False), ("with", False),
            ("moved along", False), ("ideal prop [N]", True), ("for stages", True),
            ("props in place", True),
        )
    )  # fmt: skip
    rows = "".join(_row(plan, step) for step in plan.steps)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Assembly plan</title><style>{_INSTRUCTIONS_STYLE}</style></head><body>"
        f"<h1>Assembly plan</h1>"
        f"<p>{html.escape(plan.told)}; {html.escape(plan.message)}.</p>"
        f"{_numbered_drawing(plan)}"
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
        "</div></body></html>\n"
    )


def _row(plan: Plan, step: Step) -> str:
    names = plan.model.assembly.names
    prop = {one.block: one for one in plan.props}
    rows = []
    for block, motion in zip(step.blocks, step.motion, strict=True):
        status = plan.status[block].value
        one = prop.get(block)
        cells = (
            (str(plan.step_of[block] + 1), True),
            (name_text(names[block]), False),
            (status, False),
            (", ".join(name_text(names[b]) for b in plan.partners(block)), False),
            (", ".join(f"{x:.2f}" for x in np.round(motion, 2) + 0.0), False),
            (f"{one.force:,.0f}" if one else "", True),
            (str(one.stages) if one else "", True),
            (str(len(step.props)) if step.props else "", True),
        )
        text = "".join(f"<td{' class=n' if right else ''}>{cell}</td>" for cell, right in cells)
        rows.append(f'<tr class="{status}">{text}</tr>')
    return "".join(rows)


def _numbered_drawing(plan: Plan) -> str:
    """Inline SVG of the complete structure with the number of its step at every planned block."""
    # the summary is above the drawing
    scene = plan.layers()
    bare = replace(scene.stages[-1], headline="", message="")
    scene = replace(scene, stages=(bare,), facts={}, still=0)
    figure = draw(scene, (9.0, 6.5), preset="stages")
    from matplotlib import rc_context  # slow to import

    text = io.StringIO()
    with rc_context({"svg.hashsalt": "drystone"}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    drawn = text.getvalue()
    return drawn[drawn.index("<svg") :]
