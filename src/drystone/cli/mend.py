"""``drystone mend``: why does it fall, and what would hold it?"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from drystone.cli import loading, options, verdict
from drystone.cli.answer import Answer
from drystone.cli.command import command
from drystone.cli.output import Screen
from drystone.cli.subject import Finding, Subject
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures

if TYPE_CHECKING:
    from drystone.cli.answer import Files
    from drystone.design import Diagnosis
    from drystone.results import Result
    from drystone.view import Scene

SHORT = 3
"""Regions that ``check`` tells; ``mend`` tells all."""


@command(
    "drystone mend arch.json --friction 0.3",
    "drystone mend arch.json --friction 0.3 --html why.html",
)
def mend(
    *,
    subject: Subject,
    seismic: loading.Seismic = None,
    finding: Finding,
    time_limit: options.TimeLimit = None,
    wanted: Pictures,
    waiting: Waiting,
) -> Answer:
    """Tell why a model falls, block by block, and what would hold it.

    Exit code 0: it stands already. 1: it does not. 2: bad input. 130: Ctrl-C ended the search; what
    was known by then is the answer.
    """
    model = subject.prepared(waiting, finding, seismic)
    from drystone.design import DiagnosisOptions, diagnose  # work is imported when there is some

    waiting.stage("diagnose", "diagnosing")
    chosen = DiagnosisOptions(time_limit_s=float("inf") if time_limit is None else time_limit)
    with waiting.stoppable() as stop:
        found = diagnose(model, options=chosen, progress=waiting, stop=stop)
    data = {"model": subject.model, **found.to_dict()}
    code = verdict.exit_code(found.result, strict=False)
    files = partial(_files, found, wanted)
    return Answer(data, partial(_show, data), code, model.notes, files)


def short(result: Result, waiting: Waiting) -> dict[str, Any] | None:
    """What falls and how, of the heaviest regions of a result; ``None`` where nothing falls."""
    if not result.falls:
        return None
    from drystone.design import DiagnosisOptions, diagnose  # as above

    few = DiagnosisOptions(needs=False, regions=SHORT)
    with waiting.stoppable() as stop:
        return diagnose(result.model, result=result, options=few, stop=stop).to_dict()


def _files(found: Diagnosis, wanted: Pictures) -> Files:
    if wanted.html is None and wanted.png is None:
        return [], []
    from drystone import view  # as above

    scene = diagnosis_scene(found)
    return wanted.jobs(partial(view.save_page, scene), partial(view.save_figure, scene)), []


def diagnosis_scene(found: Diagnosis) -> Scene:
    """The model with its first motion and the forces that would hold it."""
    from dataclasses import replace

    from drystone import view  # as above

    stage = view.stage_of(found.result, "diagnosis")
    point, force = found.props
    props = view.Layer(
        "props", "props that would hold it", view.LayerKind.ARROWS, "resultant", point, force,
        inward=True, width=1.8,
    )  # fmt: skip
    shown = [layer for layer in stage.layers if layer.kind is not view.LayerKind.ARROWS]
    stage = replace(
        stage,
        message="; ".join(found.sentences),
        motion=found.motion if found.regions else None,
        prop=None,
        layers=(*shown, props) if len(point) else tuple(shown),
    )
    result = found.result
    return view.Scene(result.assembly, result.contacts, (stage,), f"drystone: {stage.headline}")


def _show(data: dict[str, Any], screen: Screen) -> None:
    style = verdict.STYLE.get(data["verdict"], "bold")
    screen.line(str(data["model"]), data["verdict"].upper(), style)
    if data["message"]:
        screen.line(data["message"])
    for number, sentence in enumerate(data["sentences"], 1):
        mark = f"{number}. " if number <= len(data["regions"]) else ""
        screen.line(f"{mark}{sentence}")
    if data["stopped"]:
        screen.note(f"{data['stopped']} before all was tried")
