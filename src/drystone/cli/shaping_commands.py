"""Commands that change the shape of blocks: ``shape`` and ``cut``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError, counted
from drystone.cli import kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import Source, Subject
from drystone.cli.offered import OUTPUT, Analysis, Of, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import WithModel

if TYPE_CHECKING:
    from drystone.assembly import Assembly, Block
    from drystone.base.files import Job
    from drystone.cli.told import Files
    from drystone.design.shape_variables import ShapeVariables
    from drystone.model import Model
    from drystone.sequence import Plan


_OF_VERTICES = {
    "keep_side": "joints slide along both sides",
    "sectors": "the ends of joints have no sectors",
    "directions": "joints slide along the sides of blocks",
}
"""Arguments of vertices that move freely, and why joints that slide do not have them."""


@command(
    "drystone shape arch.json --friction 0.8 --most 0.05 --out stands.json",
    "drystone shape arch.json --aim volume --margin tilt=2deg --time-limit 2 --html light.html",
)
def shape(
    *,
    subject: Subject,
    asked: Annotated[
        Analysis,
        Of(
            "drystone.design.shape",
            ("options.aim", "options.margin", "options.least_edge", "time_limit_s"),
            shown=("options.aim",),
        ),
    ],
    move: Annotated[
        str,
        Option(
            "Move vertices freely, or slide the ends of joints along the sides of blocks, so that "
            "joint planes turn and move (free).",
            kind=kinds.one_of(("free", "joints")),
            expert=True,
        ),
    ] = "free",
    ways: Annotated[
        Analysis,
        Of(
            "drystone.design.free_vertices",
            ("most", "directions", "along", "mirror", "keep", "keep_side", "sectors"),
            shown=("most", "keep"),
            metavars={"directions": "AXES"},
        ),
    ],
    wanted: WithModel,
    waiting: Waiting,
) -> Told:
    """Move the vertices of free blocks until a model stands, weighs least, or can be tilted most.

    Vertices at one place move together, and joints stay plane, so that they stay shared. The
    verdict is that of ``check``. --html and --png show it with the edges of the model before.

    Exit code 0: it stands. 1: it does not. 2: bad input. 130: stopped by Ctrl-C, with the best
    shape so far.
    """
    for name, why in _OF_VERTICES.items():
        if move == "joints" and name in ways.given:
            raise InputError(why, where=name, remedy="leave it out")
    model = subject.prepared(waiting)
    moves = _moves(model, move, dict(ways.given))
    found = asked.of(waiting, model, moves, doing="shaping")
    return Told(found, notes=model.notes, files=partial(wanted.of, found))


def _moves(model: Model, move: str, ways: dict[str, Any]) -> ShapeVariables:
    """What may move; all blocks that are prisms stay so, unless something else is asked for."""
    from drystone import design
    from drystone.design.free_moves import prism_axis

    most = ways.pop("most", 0.1 * float(model.assembly.size[model.assembly.free].mean()))
    along = ways.pop("along", None)
    if along is None:
        along = prism_axis(model, ways.get("keep", ()))
    ways["along"] = along
    made = design.joint_moves if move == "joints" else design.free_vertices
    return made(model, most, **ways)


@command(
    "drystone cut arch.json --block springer-left --blocks 3 --out blocks.json",
    "drystone cut arch.json --block springer-left --friction 0.5 --html built.html",
)
def cut(
    *,
    source: Source,
    asked: Annotated[
        Analysis,
        Of(
            "drystone.design.cut_until_free",
            ("options.blocks", "options.friction", "options.ends", "options.most", "time_limit_s"),
            shown=("options.blocks", "options.friction"),
        ),
    ],
    block: Annotated[
        str | None, Option("The block that is cut (the only one).", metavar="NAME")
    ] = None,
    out: Annotated[Path | None, Option("Write the blocks.", OUTPUT, kind=kinds.MODEL_FILE)] = None,
    html: options.Html = None,
    waiting: Waiting,
) -> Told:
    """Cut a monolith from the bottom up into blocks that are placed one by one without help.

    Each place takes its first cut on which the part above stands: the horizontal plane, a turned
    one, a notch, or one at another height. The blocks are planned. Where a block needs help, the
    cut under it is changed, and so on. The lowest block is the support.

    Exit code 0: every block is free. 1: none of the cuts that are tried makes it so. 2: bad input.
    """
    from drystone import io

    waiting.stage("read", f"reading {source.name}")
    read = io.read_file(source.place, **source.how)
    whole = _chosen(read.assembly, block)
    found = asked.of(waiting, whole, doing="cutting")
    plan = found.plan
    blocks = None if plan is None else plan.model.model
    files = partial(_files, blocks, plan, out, html)
    return Told(found, subject=source.name, notes=read.notes, files=files)


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


def _files(model: Model | None, plan: Plan | None, out: Path | None, html: Path | None) -> Files:
    """The blocks and the page of their plan; and a remark on those that are not there."""
    jobs: list[Job] = []
    left = []
    if out is not None and model is not None:
        from drystone import io

        jobs.append((out, partial(io.write, model)))
    elif out is not None:
        left.append(str(out))
    if html is not None and plan is not None and plan.steps:
        from drystone.view import save_page

        jobs.append((html, partial(save_page, plan)))
    elif html is not None:
        left.append(str(html))
    return jobs, [f"not written: {', '.join(left)}"] if left else []
