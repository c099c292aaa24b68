"""Options that the limits share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from drystone.cli import options
from drystone.errors import InputError

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from drystone.limits import LimitOptions

Width: TypeAlias = Annotated[
    float | None, typer.Option(help="Width of the brackets, in the unit of the limit.")
]
Scan: TypeAlias = Annotated[
    int, typer.Option(help="Steps of the scan for islands before the limit is bisected.")
]
Cone: TypeAlias = Annotated[
    str, typer.Option(help="Friction of the equilibrium limit: exact, or octagon as published.")
]
EquilibriumOnly: TypeAlias = Annotated[
    bool, typer.Option("--equilibrium-only", help="Leave out the full verdict.")
]
Workers: TypeAlias = Annotated[int, typer.Option(help="Processes that work side by side.")]


def search_options(
    width: float | None, scan: int, cone: str, equilibrium_only: bool
) -> LimitOptions:
    """How to search, from the options.

    Raises
    ------
    InputError
    """
    options.positive(width, "--width")
    if scan < 1:
        raise InputError(f"is {scan}", where="--scan", remedy="give one step or more")
    from drystone.limits import LimitOptions
    from drystone.stability import FrictionCone

    cones = {"exact": FrictionCone.exact, "octagon": FrictionCone.octagon}
    if cone not in cones:
        raise InputError(f"is '{cone}'", where="--cone", remedy=f"one of {', '.join(cones)}")
    return LimitOptions(width=width, scan=scan, cone=cones[cone](), full=not equilibrium_only)


@contextmanager
def working(workers: int) -> Iterator[Executor | None]:
    """Processes to work on, or none for one worker."""
    if workers < 1:
        raise InputError(f"is {workers}", where="--workers", remedy="give one or more")
    if workers == 1:
        yield None
        return
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(workers) as executor:
        yield executor
