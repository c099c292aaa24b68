"""What a limit answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from drystone.base.display import named
from drystone.cli.base.output import LISTED, Screen
from drystone.cli.base.told import Printed
from drystone.cli.base.waiting import Waiting
from drystone.cli.base.written import Pictures

if TYPE_CHECKING:
    from drystone.cli.base.told import Files
    from drystone.limits import Limit, TiltSweep

_TITLES = {
    "equilibrium": "some forces balance the loads",
    "rest": "stands, as 'drystone check' tells",
    "robust": "stands for every contact stiffness tried",
    "uniform": "stands for uniform contact stiffness",
}
_NOTHING: Mapping[str, float] = MappingProxyType({})


def safety_factor(found: Limit) -> dict[str, float]:
    """Size of the joints, divided by the least size at which it stands."""
    stands = found.best.stands
    return {} if not stands else {"geometric safety factor": 1.0 / stands}


def answer(
    found: Limit,
    model: str,
    notes: Sequence[str],
    pictures: Pictures,
    waiting: Waiting,
    more: Mapping[str, float] = _NOTHING,
    about: str = "",
) -> Printed:
    """A limit and the pictures of its fall; exit code 1 if it does not stand at all.

    ``more`` has figures that follow from the limit, by name; ``about`` is the axis of a tilt.
    """
    others = {name.replace(" ", "_"): value for name, value in more.items()}
    data = {"model": model, **found.to_dict(), **({"axis": about} if about else {}), **others}
    data["time_s"] = {**waiting.time_s, **data["time_s"]}
    code = 0 if found.best.stands is not None else 1
    return Printed(data, partial(_show, data, more), code, notes, partial(_both, found, pictures))


def sweep_answer(sweep: TiltSweep, model: str, notes: Sequence[str], pictures: Pictures) -> Printed:
    """A polar sweep, its plot and the fall in its weakest direction."""
    data = {"model": model, **sweep.to_dict()}
    code = 0 if all(limit.best.stands is not None for limit in sweep.limits) else 1

    def files() -> Files:
        if not sweep.limits:
            return [], []
        from drystone.view import save_page, save_polar  # pictures are imported when asked for

        plot = partial(save_polar, sweep, title=Path(model).stem)
        page = partial(save_page, sweep, section=pictures.section)
        return pictures.jobs(page, plot), []

    return Printed(data, partial(_show_sweep, data), code, notes, files)


def _both(found: Limit, pictures: Pictures) -> Files:
    """Pictures of the states on either side, where there are any."""
    known = found.best.falling is not None or found.best.standing is not None
    return pictures.of(found) if known else ([], [])


def _show(data: dict[str, Any], more: Mapping[str, float], screen: Screen) -> None:
    unit = f" [{data['unit']}]" if data["unit"] else ""
    about = f" about {data['axis']}" if "axis" in data else ""
    screen.line(data["model"], f"limit of {data['parameter']}{unit}{about}")
    rows = [
        (title, _value(data[key]["stands"], "nowhere"), _value(data[key]["falls"], "-"))
        for key, title in _TITLES.items()
        if data[key] is not None and (key != "robust" or data["sensitive"])
    ]
    screen.table(("", "stands at", "gives way at"), rows)
    for name, figure in more.items():
        screen.line(f"{name}: {figure:.4g}")
    for remark in data["remarks"]:
        screen.line(remark, "joints decide:", "yellow", " ")
    for low, high in data["islands"]:
        screen.line(f"it stands again from {low:.6g} to {high:.6g}", "island:", "yellow", " ")
    if data["falling"]:
        screen.line(f"gives way: {named(data['falling'], LISTED)}")
        screen.line(data["message"])
    _show_stopped(data, screen)


def _show_sweep(data: dict[str, Any], screen: Screen) -> None:
    screen.line(data["model"], "largest tilt [deg] towards each direction")
    rows = []
    for azimuth, limit in zip(data["azimuth"], data["limits"], strict=True):
        rest = limit["rest"] or limit["equilibrium"]
        mark = "  weakest" if azimuth == data["weakest_azimuth"] else ""
        mark += "  joints decide" if limit["remarks"] else ""
        balances = _value(limit["equilibrium"]["stands"], "nowhere")
        rows.append((f"{azimuth:g}", balances, _value(rest["stands"], "nowhere") + mark))
    screen.table(("direction", "balances up to", "stands up to"), rows, listed=len(rows))
    _show_stopped(data, screen)


def _show_stopped(data: dict[str, Any], screen: Screen) -> None:
    if data["stopped"]:
        screen.line(data["stopped"], "not finished:", "bold yellow", " ")


def _value(value: float | None, none: str) -> str:
    return none if value is None else f"{value:.6g}"
