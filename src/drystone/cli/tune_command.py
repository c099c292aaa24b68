"""``drystone tune``: the parameters with which a family is best and stands."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli import families, kinds, options
from drystone.cli.command import command
from drystone.cli.offered import OUTPUT, Argument, Option
from drystone.cli.parameter_search import SearchRequest
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.cli.told import Files
    from drystone.design import Tuned


@command(
    "drystone tune arch --vary thickness_ratio=0.05:0.3 --friction 0.8 --trials 40",
    "drystone tune tower --vary edge=0.5:2 --vary count=2:6 --least volume --most height",
)
def tune(
    *,
    family: Annotated[
        str,
        Argument(
            "FAMILY",
            "A parametric family; 'drystone models' lists all. Or a shell: barrel-shell, "
            "dome-shell, free-edge-shell and others.",
        ),
    ],
    set: families.Settings = (),
    friction: options.Friction = None,
    search: SearchRequest,
    out: Annotated[
        Path | None,
        Option("Write the best model by the first goal.", OUTPUT, kind=kinds.target(".json")),
    ] = None,
    png: Annotated[
        Path | None,
        Option(
            "Draw the trials and the front: .png, .svg or .pdf.",
            OUTPUT,
            kind=kinds.target(".png", ".svg", ".pdf"),
        ),
    ] = None,
    time_limit: options.TimeLimit = None,
    waiting: Waiting,
) -> Told:
    """Search for the parameters with which a family of structures stands and is best.

    With several goals the front is listed: no other structure is better in all of them.

    Exit code 0: some structure stands. 1: none does. 2: bad input. 130: Ctrl-C ended the search;
    the trials so far are the answer.
    """
    build, known = families.shell_family(family) or families.family(family)
    given = dict(families.setting(text, known) for text in set)
    how: dict[str, Any] = {} if friction is None else {"friction": friction}
    twice = {text.partition("=")[0].replace("-", "_") for text in search.vary} & given.keys()
    if twice:
        raise InputError(
            f"{', '.join(sorted(twice))} is set, and varied",
            where="--set",
            remedy="give one of them",
        )
    made = partial(build, **given)
    found = search.run(made, known, how, waiting, time_limit)
    return Told(found, subject=family, files=partial(_files, found, made, how, out, png))


def _files(
    found: Tuned, build: Any, how: dict[str, Any], out: Path | None, png: Path | None
) -> Files:
    jobs: list[Any] = []
    if out is not None and found.front:
        from drystone import io
        from drystone.design.tune_goals import model_of

        jobs.append((out, partial(io.write, model_of(build(**found.front[0].values), how))))
    if png is not None:
        from drystone.view import save_figure  # as above

        jobs.append((png, partial(save_figure, found)))
    return jobs, []
