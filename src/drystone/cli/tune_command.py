"""``drystone tune``, and the search for parameters, which ``shell --vary`` has too."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.display import differing
from drystone.base.errors import InputError, located
from drystone.cli import families, kinds, options
from drystone.cli.command import command
from drystone.cli.model_input import HOW
from drystone.cli.offered import MODEL, OUTPUT, Analysis, Argument, Of, Option, writes
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.cli.told import Files
    from drystone.design import Parameter, Tuned, TuneOptions


@dataclass(frozen=True)
class SearchRequest:
    """What is varied, what is asked of it, and how long."""

    vary: Annotated[
        tuple[str, ...],
        Option(
            "A parameter and its bounds, or values separated by commas, to be searched. Can be "
            "given several times.",
            MODEL,
            metavar="NAME=LOW:HIGH",
        ),
    ] = ()
    least: Annotated[
        tuple[str, ...],
        Option(
            "What is to be least: volume, blocks, height, reach, props, held or a parameter "
            "(volume).",
            metavar="GOAL",
        ),
    ] = ()
    most: Annotated[tuple[str, ...], Option("What is to be most.", metavar="GOAL")] = ()
    chosen: Annotated[
        TuneOptions,
        Of(
            "drystone.design.TuneOptions",
            without=("batch",),
            shown=("props", "trials"),
            metavars={"margin": "WHAT"},
        ),
    ] = None  # type: ignore[assignment]  # made by the command
    workers: options.Workers = 1
    store: Annotated[
        Path | None,
        Option(
            "File that keeps the trials: an interrupted search continues from it.",
            OUTPUT,
            kind=kinds.target(),
        ),
    ] = None

    def refuse_without_vary(self) -> None:
        """Raise InputError where an option of the search is given, and nothing is varied."""
        given = [name for name in ("least", "most", "store") if getattr(self, name)]
        given += differing(self.chosen)
        if given or self.workers != 1:
            raise InputError(
                "is for a search of parameters",
                where=f"--{[*given, 'workers'][0]}",
                remedy="give --vary NAME=LOW:HIGH with it",
            )

    def run(
        self,
        build: Callable[..., Any],
        known: families.Parameters,
        how: Mapping[str, Any],
        waiting: Waiting,
        time_limit: float | None,
    ) -> Tuned:
        """Search for the values with which what ``build`` makes stands and is best.

        Raises
        ------
        InputError
            Nothing is varied, a parameter is not known, or the search refuses what is asked.
        """
        if not self.vary:
            raise InputError(
                "nothing is varied", where="--vary", remedy="write --vary NAME=LOW:HIGH"
            )
        ranges = [parameter_range(text, known) for text in self.vary]
        from drystone import design  # work is imported when there is some

        goals = (*self.least, *(f"-{goal}" for goal in self.most)) or ("volume",)
        waiting.stage("tune", "searching")
        waiting.checkpoint = self.store
        with waiting.keywords(time_limit, self.workers) as common:
            return design.tune(
                build, ranges, goals=goals, how=how, store=self.store, options=self.chosen, **common
            )


def parameter_range(text: str, known: families.Parameters) -> Parameter:
    """A parameter from ``NAME=LOW:HIGH`` or ``NAME=ONE,OTHER``."""
    from drystone.design import Parameter

    name, equals, bounds = text.partition("=")
    name = name.replace("-", "_")
    if not equals:
        raise InputError(f"'{text}' is not NAME=LOW:HIGH", where="--vary")
    families.refuse_unknown(name, known, "--vary")
    low, colon, high = bounds.partition(":")
    with located("--vary"):
        values = [
            families.setting(f"{name}={one}", known)[1]
            for one in ((low, high) if colon else bounds.split(","))
        ]
    if not colon:
        return Parameter(name, choices=tuple(values))
    if not all(isinstance(end, int | float) for end in values):
        raise InputError(
            f"{name} has no bounds", where="--vary", remedy="give values separated by commas"
        )
    whole = all(isinstance(end, int) for end in values)
    return Parameter(name, float(values[0]), float(values[1]), whole=whole)


@command(
    "drystone tune arch --vary thickness_ratio=0.05:0.3 --friction 0.8 --trials 20",
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
    reading: Annotated[Analysis, HOW(("friction", "ends"), shown=("friction",))],
    search: SearchRequest,
    out: Annotated[
        Path | None,
        Option("Write the best model by the first goal.", OUTPUT, kind=kinds.MODEL_FILE),
    ] = None,
    png: Annotated[
        Path | None,
        writes("Draw the trials and the front: .png, .svg or .pdf.", ".png", ".svg", ".pdf"),
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
    twice = {text.partition("=")[0].replace("-", "_") for text in search.vary} & given.keys()
    if twice:
        raise InputError(
            f"{', '.join(sorted(twice))} is set, and varied",
            where="--set",
            remedy="give one of them",
        )
    made = partial(build, **given)
    found = search.run(made, known, reading.given, waiting, time_limit)
    return Told(found, subject=family, files=partial(_files, found, made, reading.given, out, png))


def _files(
    found: Tuned, build: Any, how: Mapping[str, Any], out: Path | None, png: Path | None
) -> Files:
    from drystone import io
    from drystone.design.tuned_values import model_of
    from drystone.view import save_figure

    def write(path: Path) -> None:
        io.write(model_of(build(**found.front[0].values), how), path)

    return [(out if found.front else None, write), (png, partial(save_figure, found))], []
