"""``drystone cut``: a monolith cut into blocks until each of them is placed alone."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError, counted
from drystone.cli import kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import Source
from drystone.cli.offered import OUTPUT, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.assembly import Assembly, Block
    from drystone.base.files import Job


@command(
    "drystone cut arch.json --block springer-left --blocks 3 --out blocks.json",
    "drystone cut arch.json --block springer-left --friction 0.5 --html built.html",
)
def cut(
    *,
    source: Source,
    blocks: Annotated[int, Option("Number of blocks (4).", kind=kinds.whole(2))] = 4,
    block: Annotated[
        str | None, Option("The block that is cut (the only one).", metavar="NAME")
    ] = None,
    friction: options.Friction = None,
    most: Annotated[
        int, Option("Number of plans after which it ends (40).", kind=kinds.whole(1), expert=True)
    ] = 40,
    out: Annotated[
        Path | None, Option("Write the blocks.", OUTPUT, kind=kinds.target(".json"))
    ] = None,
    html: options.Html = None,
    time_limit: options.TimeLimit = None,
    waiting: Waiting,
) -> Told:
    """Cut a monolith from the bottom up into blocks that are placed one by one without help.

    Each place takes its first cut on which the part above stands: the horizontal plane, a turned
    one, a notch, or one at another height. The blocks are planned. Where a block needs help, the
    cut under it is changed, and so on. The lowest block is the support.

    Exit code 0: every block is free. 1: none of the cuts that are tried makes it so. 2: bad input.
    """
    from drystone import design, io

    waiting.stage("read", f"reading {source.model}")
    read = io.read_file(source.model, **source.how())
    whole = _chosen(read.assembly, block)
    asked: dict[str, Any] = {} if friction is None else {"friction": friction}
    waiting.stage("cut", "cutting")
    with waiting.keywords(time_limit) as common:
        found = design.cut_until_free(
            whole,
            options=design.CutOptions(blocks=blocks, most=most, **asked),
            **common,
        )
    return Told(
        found, subject=source.model, notes=read.notes, files=partial(_files, found, out, html)
    )


def _chosen(assembly: Assembly, name: str | None) -> Block:
    if name is not None:
        return assembly.blocks[int(assembly.indices([name])[0])]
    if len(assembly) != 1:
        raise InputError(
            f"the file has {counted(len(assembly), 'block')}",
            where="model",
            remedy="name the one that is cut, --block NAME, or change joints: drystone recut",
        )
    return assembly.blocks[0]


def _files(found: Any, out: Path | None, html: Path | None) -> tuple[list[Job], list[str]]:
    wanted = [str(path) for path in (out, html) if path is not None]
    if found.plan is None:
        return [], [f"not written: {', '.join(wanted)}"] if wanted else []
    from drystone import io
    from drystone.view import save_page

    jobs: list[Job] = []
    if out is not None:
        jobs.append((out, partial(io.write, found.plan.model.model)))
    if html is not None:
        jobs.append((html, partial(save_page, found.plan)))
    return jobs, []
