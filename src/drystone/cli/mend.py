"""``drystone mend``: why does it fall, and what would hold it?"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from drystone.cli import loading, options, output, verdict
from drystone.cli.groups import Finding, Subject, expanded
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.design import Diagnosis
    from drystone.files import Job
    from drystone.results import Result
    from drystone.view import Scene

SHORT = 3
"""Regions that ``check`` tells; ``mend`` tells all."""


@expanded
def mend(
    *,
    subject: Subject,
    seismic: loading.Seismic = None,
    finding: Finding,
    html: options.Html = None,
    png: options.Png = None,
    time_limit: options.TimeLimit = None,
    as_json: options.Json = False,
) -> int:
    """Tell why a model falls, block by block, and what would hold it.

    Exit code 0: it stands already. 1: it does not. 2: bad input. 130: Ctrl-C ended the search; what
    was known by then is the answer.
    """
    files = verdict.Files.checked(html, png)
    options.positive(time_limit, "--time-limit")
    options.apart(files.written())
    with Waiting() as waiting:
        model = subject.prepared(waiting, finding, seismic=seismic)
        from drystone.design import (
            DiagnosisOptions,
            diagnose,
        )  # work is imported when there is some

        waiting.stage("diagnose", "diagnosing")
        limit = float("inf") if time_limit is None else time_limit
        chosen = DiagnosisOptions(time_limit_s=limit)
        with waiting.stoppable() as stop:
            found = diagnose(model, options=chosen, progress=waiting, stop=stop)
        written = verdict.write(_pictures(found, files), waiting)
    data = {"model": subject.model, **found.to_dict(), "notes": list(model.notes)}
    data |= {"files": written, "time_s": dict(waiting.time_s)}
    if as_json:
        output.emit(data)
    else:
        _show(data)
    return waiting.exit_code(verdict.exit_code(found.result, strict=False))


def short(result: Result) -> dict[str, Any] | None:
    """What falls and how, of the heaviest regions of a result; ``None`` where nothing falls."""
    if not result.falls:
        return None
    from drystone.design import DiagnosisOptions, diagnose  # as above

    few = DiagnosisOptions(needs=False, regions=SHORT)
    return diagnose(result.model, result=result, options=few).to_dict()


def _pictures(found: Diagnosis, files: verdict.Files) -> list[Job]:
    if not files.written():
        return []
    from drystone import view  # as above

    scene = diagnosis_scene(found)
    return files.jobs(partial(view.save_page, scene), partial(view.save_figure, scene))


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


def _show(data: dict[str, Any]) -> None:
    console = output.console()
    style = verdict.STYLE.get(data["verdict"], "bold")
    console.print(f"[{style}]{data['verdict'].upper()}[/]  {output.safe(str(data['model']))}")
    if data["message"]:
        console.print(output.safe(data["message"]))
    for number, sentence in enumerate(data["sentences"], 1):
        mark = f"{number}. " if number <= len(data["regions"]) else ""
        console.print(f"{mark}{output.safe(sentence)}")
    if data["stopped"]:
        console.print(f"[yellow]note:[/] {data['stopped']} before all was tried")
    for note in data["notes"]:
        console.print(f"[yellow]note:[/] {output.safe(note)}")
    for name in data["files"]:
        console.print(f"wrote {output.safe(name)}")
