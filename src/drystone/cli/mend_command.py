"""``drystone mend``: why it falls, and which changes make it stand."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli import kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import Subject
from drystone.cli.offered import OUTPUT, Of, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import WithModel

if TYPE_CHECKING:
    from drystone.cli.told import Files
    from drystone.design import Diagnosis, MendOptions, Mends
    from drystone.results import Result

_SHORT = 3
"""Regions that ``check`` prints; ``mend`` prints all."""


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
            metavars={"margin": "WHAT", "kinds": "KIND", "keep": "BLOCKS"},
        ),
    ],
    everything: Annotated[
        bool, Option("List what was tried without success, too.", flags=("--all",), expert=True)
    ] = False,
    apply: Annotated[
        int | None,
        Option(
            "Number of the mend to make, as in the list.", OUTPUT, kind=kinds.COUNT, expert=True
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
    time_limit: options.TimeLimit = None,
    wanted: WithModel,
    waiting: Waiting,
) -> Told:
    """Say why a model falls, and find changes with which it stands.

    Each mend is checked on the whole model. With --auto or --apply, --out writes the mended model;
    --html and --png show it with the edges of the model before.

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
            notes, files = list(model.notes), wanted
            if not (made.changes or made.stands) and wanted.out is not None:
                notes.append(f"{wanted.out} is not written: no mend was made")
                files = replace(wanted, out=None)
            return Told(made, notes=notes, files=partial(files.of, made))
        mends = design.find_mends(model, options=chosen, **common)
    stands = not mends.mends and not mends.diagnosis.regions
    pictures = replace(wanted, out=None)
    notes = [*model.notes, *(mends.failures() if everything else ())]
    told = Told(mends, notes=notes, files=partial(pictures.of, mends))
    if apply is not None and not stands:
        if not 1 <= apply <= len(mends.mends):
            raise _not_listed(apply, mends)
        from drystone.stability import check

        one = mends.mends[apply - 1]
        result = check(one.model)
        made_one = replace(one, result=result, stands=result.stable)
        told = replace(
            told, also={"applied": made_one}, exit_code=made_one.code,
            files=partial(wanted.of, made_one),
        )  # fmt: skip
    if pages is not None:
        told = replace(told, files=partial(_with_pages, told.files, mends, pages), into=pages)
    return told


def _not_listed(apply: int, mends: Mends) -> InputError:
    """What is said of a number that no mend has."""
    if mends.mends:
        what, remedy = f"{len(mends.mends)} were found", "give the number of one that is listed"
    else:
        tried = ", ".join(dict.fromkeys(one.kind for _, one in mends.tried))
        what, remedy = f"{tried or 'nothing'} failed", "leave it out, with --all, to see why"
    return InputError(f"there is no mend {apply}: {what}", where="--apply", remedy=remedy)


def _with_pages(others: Any, mends: Mends, folder: Path) -> Files:
    """The other files, and a page of each mend."""
    from drystone.view import save_page  # as above

    jobs, notes = others()
    for number, one in enumerate(mends.mends, 1):
        jobs.append((folder / f"mend-{number:02d}.html", partial(save_page, one)))
    return jobs, notes


def _refuse(diagnose: bool, auto: bool, apply: int | None, out: Path | None) -> None:
    """Refuse options that contradict each other."""
    if diagnose + auto + (apply is not None) > 1:
        raise InputError(
            "--diagnose, --auto and --apply ask for different things", remedy="give one of them"
        )
    if out is not None and not auto and apply is None:
        raise InputError(
            "no mend is made", where="--out", remedy="add --auto, or --apply with a number"
        )


def short(result: Result, waiting: Waiting) -> dict[str, Diagnosis]:
    """Why the heaviest regions of a result fall; nothing if nothing falls, or joints crush."""
    from drystone.design import DiagnosisOptions, diagnose  # as above
    from drystone.stability.strength import CRUSHES

    if not result.falls or result.message.startswith(CRUSHES):
        return {}

    few = DiagnosisOptions(needs=False, regions=_SHORT)
    with waiting.stoppable() as stop:
        return {"diagnosis": diagnose(result.model, result=result, options=few, stop=stop)}
