"""``drystone demo``: check a built-in vault."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from drystone.cli.base import verdict
from drystone.cli.base.answer import Answer
from drystone.cli.base.command import OUTPUT, Option, command
from drystone.cli.base.kinds import output_path
from drystone.cli.base.waiting import Waiting
from drystone.cli.base.written import Pictures
from drystone.cli.inputs import options

if TYPE_CHECKING:
    from drystone.cli.base.answer import Files

NAME = "drystone-demo"


@command("drystone demo", "drystone demo --friction 0.3 --folder .")
def demo(
    *,
    friction: options.Friction = None,
    folder: Annotated[str, Option("Folder for the model, the page and the figure.", OUTPUT)] = ".",
    waiting: Waiting,
) -> Answer:
    """Check a built-in vault, and write its model, a page and a figure.

    The files are drystone-demo.json, drystone-demo.html and drystone-demo.png.
    """
    model_path, page, figure = (
        output_path(str(Path(folder) / f"{NAME}{suffix}"), (suffix,))
        for suffix in (".json", ".html", ".png")
    )
    from drystone import io  # the program starts fast: work is imported when there is some
    from drystone.model import Model
    from drystone.models import vault

    waiting.stage("read", "building the vault")
    model = Model.of(vault(), friction=friction)
    result = verdict.solve(model, waiting, None)

    def files() -> Files:
        return [(model_path, partial(io.write, model)), *Pictures(page, figure).of(result)[0]], []

    return verdict.answer(result, waiting, "built-in vault", files)
