"""Limits on the terminal, as JSON, and as pictures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from drystone.cli import output
from drystone.cli.verdict import Files, write
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.limits import Limit, TiltSweep
    from drystone.model import Model

TITLES = {
    "equilibrium": "some forces balance the loads",
    "rest": "stands for some contact stiffness",
    "uniform": "stands for uniform contact stiffness",
}
NOTHING: Mapping[str, float] = MappingProxyType({})
NAMED = 12
"""Blocks named on the terminal; --json has all."""


def safety_factor(found: Limit) -> dict[str, float]:
    """How many times larger the joints are than the least that stand."""
    stands = found.best.stands
    return {} if not stands else {"geometric safety factor": 1.0 / stands}


def tell(
    found: Limit,
    model: str,
    notes: Iterable[str],
    files: Files,
    waiting: Waiting,
    as_json: bool,
    more: Mapping[str, float] = NOTHING,
) -> int:
    """Print a limit and write its page; 0 when there is one, 1 when it never stood.

    ``more`` are figures that follow from the limit, by their names.
    """
    others = {name.replace(" ", "_"): value for name, value in more.items()}
    data = {"model": model, **found.to_dict(), **others, "notes": list(notes), "files": []}
    data["time_s"] = {**waiting.time_s, **data["time_s"]}
    falling = found.best.falling
    state = falling if falling is not None else found.best.standing
    if state is not None:
        files.write(found, waiting, model)
        data["files"] += files.written()
    if as_json:
        output.emit(data)
    else:
        _show(data, more)
    return waiting.exit_code(0 if found.best.stands is not None else 1)


def tell_sweep(
    sweep: TiltSweep, model: str, prepared: Model, files: Files, waiting: Waiting, as_json: bool
) -> int:
    """Print a polar sweep and write its plot."""
    data = {"model": model, **sweep.to_dict(), "notes": list(prepared.notes), "files": []}
    data["time_s"] = dict(waiting.time_s)
    if files.written() and sweep.limits:
        from drystone import view  # pictures are imported when asked for

        page = partial(view.save_page, sweep, source=model)
        plot = partial(view.save_polar, sweep, title=Path(model).stem)
        data["files"] += write(files.jobs(page, plot), waiting)
    if as_json:
        output.emit(data)
    else:
        _show_sweep(data)
    stand = all(limit.best.stands is not None for limit in sweep.limits)
    return waiting.exit_code(0 if stand else 1)


def _show(data: dict[str, Any], more: Mapping[str, float]) -> None:
    from rich.markup import escape
    from rich.table import Table

    console = output.console()
    unit = f" [{data['unit']}]" if data["unit"] else ""
    title = escape(f"limit of {data['parameter']}{unit}")
    console.print(f"[bold]{title}[/]  {escape(data['model'])}")
    table = Table("", "stands at", "falls at", box=None)
    for key, title in TITLES.items():
        bracket = data[key]
        if bracket is not None:
            table.add_row(
                title, _value(bracket["stands"], "nowhere"), _value(bracket["falls"], "-")
            )
    console.print(table)
    for name, figure in more.items():
        console.print(f"{name}: {figure:.4g}")
    for low, high in data["islands"]:
        console.print(f"[yellow]island:[/] it stands again from {low:.6g} to {high:.6g}")
    if data["falling"]:
        names = ", ".join(data["falling"][:NAMED])
        others = len(data["falling"]) - NAMED
        console.print(f"falls: {escape(names)}" + (f" and {others} more" if others > 0 else ""))
        console.print(escape(data["message"]))
    _show_end(console, data)


def _show_sweep(data: dict[str, Any]) -> None:
    from rich.markup import escape
    from rich.table import Table

    console = output.console()
    title = escape("largest tilt [deg] towards each direction")
    console.print(f"[bold]{title}[/]  {escape(data['model'])}")
    table = Table("direction", "balances up to", "stands up to", box=None)
    for azimuth, limit in zip(data["azimuth"], data["limits"], strict=True):
        rest = limit["rest"] or limit["equilibrium"]
        mark = "  weakest" if azimuth == data["weakest_azimuth"] else ""
        balances = _value(limit["equilibrium"]["stands"], "nowhere")
        table.add_row(f"{azimuth:g}", balances, _value(rest["stands"], "nowhere") + mark)
    console.print(table)
    _show_end(console, data)


def _show_end(console: Any, data: dict[str, Any]) -> None:
    from rich.markup import escape

    if data["stopped"]:
        console.print(f"[bold yellow]not finished:[/] {data['stopped']}")
    for note in data["notes"]:
        console.print(f"[yellow]note:[/] {escape(note)}")
    times = ", ".join(f"{key} {value:.2f} s" for key, value in data["time_s"].items())
    console.print(f"[dim]{times}[/]")
    for name in data["files"]:
        console.print(f"wrote {escape(name)}")


def _value(value: float | None, none: str) -> str:
    return none if value is None else f"{value:.6g}"
