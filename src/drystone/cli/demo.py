"""``drystone demo``: the main job on a built-in vault."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from drystone.cli import options, output, verdict
from drystone.cli.waiting import Waiting


def demo(
    friction: options.Friction = None,
    folder: Annotated[
        str, typer.Option(help="Folder for drystone-demo.html and drystone-demo.png.")
    ] = ".",
    as_json: options.Json = False,
) -> int:
    """Check a built-in vault; write drystone-demo.html and drystone-demo.png."""
    files = verdict.Files.checked(
        str(Path(folder) / "drystone-demo.html"), str(Path(folder) / "drystone-demo.png")
    )
    from drystone.model import Model
    from drystone.models import (
        vault,
    )  # the program starts fast: work is imported when there is some

    with Waiting() as waiting:
        waiting.stage("read", "building the vault")
        result = verdict.solve(Model.of(vault(), friction=friction), waiting, None)
        files.write(result, waiting)
    data = verdict.content(result, waiting.time_s, "built-in vault", files)
    if as_json:
        output.emit(data)
    else:
        verdict.show(data)
    return waiting.exit_code(verdict.exit_code(result, strict=False))
