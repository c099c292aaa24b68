"""``drystone limit thickness``: the least thickness of a parametric model."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli import families, kinds
from drystone.cli.command import command
from drystone.cli.offered import Analysis, Argument, Of, Option
from drystone.cli.told import Told
from drystone.cli.waiting import Waiting
from drystone.cli.written import Pictures

if TYPE_CHECKING:
    from drystone.assembly import Assembly

SEARCHED = {
    "arch": ("thickness_ratio", "", (0.2, 0.05)),
    "buttressed-arch": ("thickness", "m", (0.5, 0.05)),
    "barrel-vault": ("thickness", "m", (0.5, 0.05)),
    "vault": ("thickness", "m", (0.4, 0.01)),
    "dome": ("thickness", "m", (0.5, 0.05)),
}
"""Parameter that is thickness, its unit, and the range that is searched, by family."""


@command(
    "drystone limit thickness arch --set voussoirs=12",
    "drystone limit thickness arch --friction 0.8 --html thin.html",
)
def thickness(
    *,
    family: Annotated[
        str, Argument("FAMILY", "A parametric model.", kinds.one_of(SEARCHED, "there is no '{}'"))
    ],
    set: families.Settings = (),
    parameter: Annotated[str | None, Option("Search another parameter than the thickness.")] = None,
    thick: Annotated[
        float | None,
        Option(
            "Value at which the search starts; the model should stand there.", flags=("--from",)
        ),
    ] = None,
    thin: Annotated[
        float | None, Option("Value at which the search ends.", flags=("--to",))
    ] = None,
    asked: Annotated[
        Analysis,
        Of(
            "drystone.limits.limit_thickness",
            without=("find", "parameter", "unit"),
            shown=("friction",),
        ),
    ],
    pictures: Pictures,
    waiting: Waiting,
) -> Told:
    """The least thickness at which a parametric model stands."""
    name, unit, (first, last) = SEARCHED[family]
    build, known = families.family(family)
    if parameter is not None and parameter != name:
        if thick is None or thin is None:
            raise InputError(
                "needs a range", where="--parameter", remedy="give --from and --to too"
            )
        families.refuse_unknown(parameter, known, "--parameter")
        name, unit = parameter, ""
    fixed = dict(families.setting(text, known) for text in set)
    if name in fixed:
        raise InputError(f"'{name}' is what is searched", where="--set", remedy="leave it out")
    from drystone.limits import limit_thickness

    start = first if thick is None else thick
    made = partial(_built, build, name, fixed)
    if pictures.section is not None:
        pictures.require_through(made(start))
    asked = asked.instead(limit_thickness, parameter=name, unit=unit)
    found = asked.of(waiting, made, start, last if thin is None else thin)
    notes = [] if {thick, thin} - {None} else ["--from and --to search another range"]
    return Told(found, subject=family, notes=notes, files=partial(pictures.of, found))


def _built(
    build: Callable[..., Assembly], name: str, fixed: dict[str, Any], value: float
) -> Assembly:
    return build(**fixed, **{name: value})
