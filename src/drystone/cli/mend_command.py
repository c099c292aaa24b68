"""``drystone mend``, ``shape`` and ``cut``: why it falls, and which changes make it stand."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError, counted, located
from drystone.cli import kinds, offered
from drystone.cli.command import command
from drystone.cli.model_input import Source, Subject
from drystone.cli.offered import OUTPUT, Analysis, Of, Option
from drystone.cli.told import Told, WithModel
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.assembly import Assembly, Block
    from drystone.cli.told import Files, Jobs
    from drystone.design import Diagnosis, MendOptions, Mends
    from drystone.design.shape_values import ShapeVariables
    from drystone.model import Model
    from drystone.results import Result
    from drystone.sequence import Plan, StageAnswer


@command(
    "drystone mend arch.json --friction 0.3 --diagnose --html why.html",
    "drystone mend arch.json --margin friction=0.9x --auto --out firm.json",
)
def mend(
    *,
    subject: Subject,
    diagnose: Annotated[
        bool,
        Option("Say why it falls and what is missing, without a search for mends.", expert=True),
    ] = False,
    auto: Annotated[
        bool, Option("Make the cheapest mend of each region until the model stands.")
    ] = False,
    chosen: Annotated[
        MendOptions,
        Of(
            "drystone.design.MendOptions",
            flags={"kinds": "--kind"},
            metavars={
                "margin": "WHAT",
                "kinds": "KIND",
                "keep": "BLOCKS",
                "train": "NAME|FILE",
            },
        ),
    ],
    everything: Annotated[
        bool, Option("List what was tried without success, too.", flags=("--all",), expert=True)
    ] = False,
    apply: Annotated[
        tuple[int, ...] | None,
        Option(
            "Numbers of the mends to make, as in the list: one for each part that falls, as 1,4.",
            OUTPUT,
            kind=kinds.COUNTS,
            expert=True,
        ),
    ] = None,
    pages: Annotated[
        Path | None,
        Option(
            "Folder for a page of each mend: the mended model, with edges of what it was.",
            OUTPUT,
            kind=kinds.FOLDER,
            expert=True,
        ),
    ] = None,
    time_limit: offered.TimeLimit = None,
    wanted: WithModel,
    waiting: Waiting,
) -> Told:
    """Say why a model falls, and find changes with which it stands.

    Each mend is checked on the whole model. With --auto or --apply the answer is that of the mended
    model: --out writes it, --html and --png show it with the edges of the model before.

    Exit code 0: it stands, already or mended. 1: it does not. 2: bad input.
    130: stopped by Ctrl-C, with what is known so far.
    """
    _refuse(diagnose, auto, apply, wanted.out)
    if pages is not None and (diagnose or auto):
        raise InputError(
            "is for the list of mends", where="--pages", remedy="leave out --diagnose and --auto"
        )
    from drystone import design  # work is imported when there is some

    model = subject.prepared(waiting)
    wanted.require_through(model.assembly)
    waiting.stage("diagnose", "diagnosing")
    with waiting.keywords(time_limit) as common:
        if diagnose:
            why = design.diagnose(model, **common)
            return Told(why, notes=model.notes, files=partial(wanted.of, why))
        waiting.stage("mend", "mending")
        if auto:
            made = design.mend(model, options=chosen, **common)
            notes, files = [*model.notes, *chosen.margin.remarks(model)], wanted
            if not (made.changes or made.stands) and wanted.out is not None:
                notes.append(f"{wanted.out} is not written: no mend was made")
                files = replace(wanted, out=None)
            return Told(made, notes=notes, files=partial(files.of, made))
        mends = design.find_mends(model, options=chosen, **common)
    stands = not mends.mends and not mends.diagnosis.regions
    pictures = replace(wanted, out=None)
    notes = [*model.notes, *chosen.margin.remarks(model), *_notes(mends, chosen, everything)]
    told = Told(mends, notes=notes, files=partial(pictures.of, mends))
    if apply is not None and stands:
        left = "no mend is made" if wanted.out is None else f"{wanted.out} is not written"
        notes.append(f"{left}: no mend is {'known' if mends.code else 'needed'}")
    elif apply is not None:
        with waiting.keywords(time_limit) as common, located("--apply"):
            made_some = mends.together(apply, options=chosen, **common)
        notes = [*model.notes, *chosen.margin.remarks(model)]
        told = Told(made_some, notes=notes, files=partial(wanted.of, made_some))
    if pages is not None:
        told = replace(told, files=partial(_with_pages, told.files, mends, pages), into=pages)
    return told


_OF_BRIDGES = (
    "backing of the haunches, a saddle and more cover are not tried: build them, such as by "
    "drystone models segmental-bridge --set backing=0.6 --set ring=0.7, or by cover of the fill"
)


def _notes(mends: Mends, chosen: MendOptions, everything: bool) -> list[str]:
    """What is not in the list of mends, or that there is more; and that no margin was asked for."""
    notes = mends.failures() if everything else []
    if mends.tried and not everything:
        notes = ["--all lists every mend, and all that was tried without success"]
    if mends.mends and not chosen.margin.words:
        notes.append("no margin was asked for: --margin tilt=2deg asks for one")
    if chosen.train is not None and mends.diagnosis.regions:
        if not any(one.stands for one in mends.mends):
            notes.append("no mend carries the train at all places: --auto goes on to the next one")
        notes.append(_OF_BRIDGES)
    return notes


def _with_pages(others: Any, mends: Mends, folder: Path) -> Files:
    """The other files, and a page of each mend."""
    from drystone.view import save_page  # as above

    jobs, notes = others()
    for number, one in enumerate(mends.mends, 1):
        jobs.append((folder / f"mend-{number:02d}.html", partial(save_page, one)))
    return jobs, notes


def _refuse(diagnose: bool, auto: bool, apply: tuple[int, ...] | None, out: Path | None) -> None:
    """Refuse options that contradict each other."""
    if diagnose + auto + (apply is not None) > 1:
        raise InputError(
            "--diagnose, --auto and --apply ask for different things", remedy="give one of them"
        )
    if out is not None and not auto and apply is None:
        raise InputError(
            "no mend is made", where="--out", remedy="add --auto, or --apply with a number"
        )


def may_mend(found: Result | StageAnswer) -> bool:
    """Whether mends are looked for: of what falls, where no joint crushes."""
    from drystone.answer import Verdict  # as above
    from drystone.stability.strength import WEAK

    return found.verdict is Verdict.UNSTABLE and WEAK not in found.message


def short(result: Result, waiting: Waiting) -> dict[str, Diagnosis]:
    """Why the heaviest regions of a result fall; nothing if nothing falls, or joints crush."""
    if not may_mend(result):
        return {}
    from drystone.design import DiagnosisOptions, diagnose  # as above

    few = DiagnosisOptions.brief()
    with waiting.stoppable() as stop:
        return {"diagnosis": diagnose(result.model, result=result, options=few, stop=stop)}


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
    """Move the vertices of free blocks until a model stands, weighs least, or reaches farthest.

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
    from drystone.design.shared_planes import prism_axis

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
    html: offered.Html = None,
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
    from drystone import io
    from drystone.view import save_page

    drawn = plan if plan is not None and plan.steps else None
    files: list[tuple[Path | None, Any, Any]] = [(out, model, io.write), (html, drawn, save_page)]
    left = [str(path) for path, what, _ in files if path is not None and what is None]
    jobs: Jobs = [(path, partial(write, what)) for path, what, write in files if what is not None]
    return jobs, [f"not written: {', '.join(left)}"] if left else []
