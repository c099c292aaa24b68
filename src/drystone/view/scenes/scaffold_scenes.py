"""A plan with its scaffolding as a scene that plays block by block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drystone.answer.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage
from drystone.base.arrays import Floats
from drystone.base.errors import counted
from drystone.results import Verdict
from drystone.sequence import Centring, Rope, Scaffolding, ScaffoldItem, Strut
from drystone.view.scenes.plan_scenes import plan_scene

_WIDE = 3.0
"""Width of a strut or a rope, by that of other lines; chosen by eye."""


def scaffold_scene(made: Scaffolding) -> Scene:
    """The scene of the plan, with the struts, ropes, clamps or centring of every stage.

    A stage that does not stand with them, or overloads one of them, says so.

    Examples
    --------
    >>> from drystone.models import arch
    >>> from drystone.sequence import PlanOptions, Rules, plan, scaffolding
    >>> found = plan(arch(0.3, 5), friction=0.6, options=PlanOptions(rules=Rules(hands=1)))
    >>> scene = scaffold_scene(scaffolding(found, "strut"))
    >>> [layer.label for layer in scene.stages[2].layers if layer.key == "scaffold"]
    ['4 struts']
    """
    scene, plan = plan_scene(made.plan), made.plan
    shown = [number for number, step in enumerate(plan.steps) for _ in step.blocks]
    stages = [
        _stage(made, number, stage)
        for number, stage in zip(shown, scene.stages[: len(shown)], strict=True)
    ]
    (summary,) = scene.stages[len(shown) :]
    if not made.works:
        failed = (
            made.stopped or f"{counted(len(made.failed), 'step')} of {len(plan.steps)} do not stand"
        )
        summary = replace(
            summary,
            message=f"with ideal props: {summary.message}",
            headline=f"Not every stage stands with {_names(made, 2)}: {failed}",
            verdict=Verdict.UNDECIDED if made.stopped else Verdict.UNSTABLE,
        )
    return replace(scene, stages=(*stages, summary))


def _stage(made: Scaffolding, number: int, stage: SceneStage) -> SceneStage:
    """A stage with what is set up at it, and with its verdict."""
    names = made.plan.model.assembly.names
    held = {names[block] for block in made.plan.steps[number].props}
    items = [item for item in made.items if _name(item, names) in held]
    stage = replace(stage, layers=(*stage.layers, *_layers(items, made)))
    if number not in made.failed:
        return stage
    row = next((one for one in made.stages if one["step"] == number), None)
    if row is None:  # nothing is held, and it does not stand without
        return stage
    over, verdict = int(row["overloaded"]), Verdict(row["verdict"])
    if verdict is Verdict.STABLE:
        said, verdict = f"{_names(made, over)} overloaded: {over} of {len(items)}", Verdict.UNSTABLE
    else:
        known = "does not stand" if verdict is Verdict.UNSTABLE else "not known to stand"
        said = f"{known} with {_names(made, len(items))}"
    block = stage.headline.partition(":")[0]
    return replace(stage, headline=f"{block}: {said}", verdict=verdict)


def _name(item: ScaffoldItem, names: Sequence[str]) -> str:
    return item.block if isinstance(item.block, str) else names[item.block]


def _names(made: Scaffolding, count: int) -> str:
    """The kind of the scaffolding, in plural where there are several."""
    kind = made.support.value
    return kind if count == 1 or kind == "centring" else f"{kind}s"


def _layers(items: Sequence[ScaffoldItem], made: Scaffolding) -> tuple[Layer, ...]:
    """Bars of struts and ropes, edges of centring, a mark for each clamp."""
    if not items:
        return ()
    label = f"{len(items)} {_names(made, len(items))}"
    assembly = made.plan.model.assembly
    ends: list[tuple[Floats, Floats]] = []
    for item in items:
        if isinstance(item, Strut):
            ends.append((np.array([item.foot]), np.array([item.head])))
        elif isinstance(item, Rope):
            ends.append((np.array([item.at]), np.array([item.anchor])))
        elif isinstance(item, Centring):
            ends.append((item.face, np.roll(item.face, -1, axis=0)))
    if not ends:
        block = assembly.indices([item.block for item in items])
        place = assembly.centroid[block]
        mark = MarkerShape.DIAMOND
        return (Layer("scaffold", label, LayerKind.MARKERS, "added", place, shape=mark),)
    start, end = (np.concatenate(side) for side in zip(*ends, strict=True))
    return (Layer("scaffold", label, LayerKind.LINES, "added", start, end - start, width=_WIDE),)
