"""``drystone shape``: vertices moved by gradients until a model stands, or is lightest."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

from drystone.base.errors import InputError
from drystone.cli import kinds
from drystone.cli.command import command
from drystone.cli.mend_command import ChangedFiles, margins
from drystone.cli.model_input import Finding, Subject
from drystone.cli.offered import Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.design.shape_variables import ShapeVariables


@command(
    "drystone shape arch.json --friction 0.8 --most 0.05 --out stands.json",
    "drystone shape arch.json --aim volume --margin tilt=2deg --time-limit 2 --html light.html",
)
def shape(
    *,
    subject: Subject,
    finding: Finding,
    aim: Annotated[
        str,
        Option(
            "To stand, the least volume, or the largest tilt to each side (stand).",
            kind=kinds.one_of(("stand", "volume", "tilt")),
        ),
    ] = "stand",
    most: Annotated[
        float | None,
        Option("Largest move of a vertex in m (a tenth of a block).", kind=kinds.POSITIVE),
    ] = None,
    least_edge: Annotated[
        float | None,
        Option("Least length of an edge that moves, in m.", kind=kinds.POSITIVE, expert=True),
    ] = None,
    move: Annotated[
        str,
        Option(
            "Move vertices freely, or slide the ends of joints along the sides of blocks, so that "
            "joint planes turn and move (free).",
            kind=kinds.one_of(("free", "joints")),
            expert=True,
        ),
    ] = "free",
    directions: Annotated[
        str | None,
        Option(
            "Axes along which vertices may move (all but --along).", metavar="AXES", expert=True
        ),
    ] = None,
    along: Annotated[
        str | None,
        Option(
            "Axis along which blocks are prisms, before and after; none for domes and shells (y, "
            "x or z where all blocks are, else none).",
            kind=kinds.one_of(("x", "y", "z", "none")),
            expert=True,
        ),
    ] = None,
    mirror: Annotated[
        str | None,
        Option(
            "Axis along which it stays its own mirror image.",
            kind=kinds.one_of(("x", "y", "z")),
            expert=True,
        ),
    ] = None,
    sectors: Annotated[
        int,
        Option(
            "Equal sectors about a vertical axis that stay equal, with --move free (1).",
            kind=kinds.whole(1),
            expert=True,
        ),
    ] = 1,
    keep: Annotated[
        tuple[str, ...],
        Option(
            "Blocks whose vertices stay: names and patterns, separated by commas, as for "
            "--supports. Can be given several times.",
            metavar="BLOCK",
        ),
    ] = (),
    keep_side: Annotated[
        str | None,
        Option(
            "Side whose vertices stay, with --move free.",
            kind=kinds.one_of(("intrados", "extrados")),
            expert=True,
        ),
    ] = None,
    changed: ChangedFiles,
    waiting: Waiting,
) -> Told:
    """Move the vertices of free blocks until a model stands, weighs least, or can be tilted most.

    Vertices at one place move together, and joints stay plane, so that they stay shared. The
    verdict is that of
    ``check``. --html and --png show it with the edges of the model before.

    Exit code 0: it stands. 1: it does not. 2: bad input. 130: stopped by Ctrl-C, with the best
    shape so far.
    """
    for given, option, why in (
        (keep_side is not None, "--keep-side", "joints slide along both sides"),
        (sectors > 1, "--sectors", "the ends of joints have no sectors"),
        (directions is not None, "--directions", "joints slide along the sides of blocks"),
    ):
        if move == "joints" and given:
            raise InputError(why, where=option, remedy="leave it out")
    stands_at = margins(changed.margin)
    from drystone import design  # work is imported when there is some
    from drystone.design.free_moves import prism_axis

    model = subject.prepared(waiting, finding)
    size = float(model.assembly.size[model.assembly.free].mean())
    farthest = 0.1 * size if most is None else most
    prisms = prism_axis(model, keep) if along is None else along if along != "none" else None
    moves: ShapeVariables
    if move == "joints":
        moves = design.joint_moves(model, farthest, prisms, mirror, keep)
    else:
        moves = design.free_vertices(
            model, farthest, directions, prisms, mirror, keep, keep_side, sectors
        )
    chosen = design.ShapeOptions(
        aim=design.ShapeAim(aim), margin=stands_at, least_edge=least_edge or 0.0
    )
    waiting.stage("shape", "shaping")
    with waiting.keywords(changed.time_limit) as common:
        found = design.shape(model, moves, options=chosen, **common)
    return Told(found, notes=model.notes, files=partial(changed.files, found))
