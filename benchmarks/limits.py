"""Limits beside closed forms and published figures: ``python -m benchmarks.limits``.

Writes docs/trust/tables/limits.csv. With ``--model FILE`` the least friction and the tilt
limit of a model of one's own are timed too (friction 0.84, its lowest blocks fixed).
"""

from __future__ import annotations

import argparse
import platform
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

import drystone
from benchmarks.tables import TABLES, write_table
from drystone import Assembly, Contacts, LoadCase, io, supports
from drystone.detection import find_contacts
from drystone.limits import (
    Bracket,
    Limit,
    LimitOptions,
    limit_friction,
    limit_load,
    limit_thickness,
    limit_tilt,
    tilt_sweep,
)
from drystone.model import Model
from drystone.models import arch, buttressed_arch, dome, ferris_wall, incline, lune, tower
from drystone.programs import FrictionCone

CPU_NOTE = "CPU seconds of one thread"


@dataclass(frozen=True)
class Case:
    """A limit whose value is known.

    Attributes
    ----------
    name, source
    known
        The figure, for equilibrium.
    tolerance
    find
    """

    name: str
    source: str
    known: float
    tolerance: float
    find: Callable[[], Limit]


def joints(assembly: Assembly, friction: float) -> Contacts:
    return find_contacts(assembly, friction=friction).contacts


def slippery_walls(assembly: Assembly) -> Contacts:
    contacts = joints(assembly, 1.0)
    wall = np.isin(contacts.block_a, (1, 2)) | np.isin(contacts.block_b, (1, 2))
    return contacts.with_friction(np.where(wall, 0.0, 1.0))


def tilt(assembly: Assembly, friction: float, axis: str, **options: object) -> Limit:
    chosen = LimitOptions(width=0.01, **options)  # type: ignore[arg-type]  # passed on
    return limit_tilt(Model(assembly, joints(assembly, friction)), axis, options=chosen)


def thinnest_arch(voussoirs: int, width: float) -> Limit:
    return limit_thickness(
        lambda ratio: arch(ratio, voussoirs),
        0.13,
        0.1,
        friction=1.0,
        options=LimitOptions(width=width, scan=2, equilibrium_only=voussoirs >= 100),
    )


def pushed_wall(number: int) -> Limit:
    assembly = ferris_wall(number)
    contacts = joints(assembly, 0.65)
    return limit_load(Model(assembly, contacts), LoadCase.seismic(assembly, 1.0))


def least_friction(assembly: Assembly, start: float) -> Limit:
    return limit_friction(Model(assembly, joints(assembly, start)))


def cases() -> list[Case]:
    steep, flat = (float(np.tan(np.deg2rad(a))) for a in (43.0, 21.8))
    octagon = FrictionCone.octagon()
    return [
        Case("cube on a cube, friction 2: tilt [deg]", "topples at 45", 45.0, 0.01,
             partial(tilt, tower(2), 2.0, "x")),
        Case("block on a slope of 20 deg: least friction", "tan 20", 0.36397, 1e-3,
             partial(least_friction, incline(20.0), 0.6)),
        Case("arch, 36 voussoirs: least t/R", "independent LP", 0.107424, 1e-4,
             partial(thinnest_arch, 36, 1e-5)),
        Case("arch, 400 voussoirs: least t/R", "Milankovitch 1907: 0.1075", 0.107477, 1e-4,
             partial(thinnest_arch, 400, 1e-5)),
        Case("arch, t/R 0.15, 43 deg of friction: tilt [deg]", "Kao 2022: 8.2", 8.246, 0.02,
             partial(tilt, arch(0.15), steep, "y")),
        Case("arch, t/R 0.15, 21.8 deg of friction: tilt [deg]", "Kao 2022: 3.0", 3.006, 0.02,
             partial(tilt, arch(0.15), flat, "y")),
        Case("arch, t/R 0.22: least friction", "Cocchetti, Rizzi 2020", 0.309215, 1e-3,
             partial(least_friction, arch(0.22, 100), 0.6)),
        Case("buttressed arch: least friction", "Kao 2023, 6.1.2 (of Iannuzzo 2020): 0.31",
             0.309, 2e-3, partial(least_friction, buttressed_arch(), 0.6)),
        Case("buttressed arch: tilt [deg]", "Kao 2023, 6.1.2 (of Iannuzzo 2020): 12", 12.12, 0.1,
             partial(tilt, buttressed_arch(), 0.6, "y")),
        Case("dome with oculus, eight-sided pyramid: tilt [deg]", "Kao 2023, 6.1.3: 32", 32.0, 1.0,
             partial(tilt, dome(), 0.6, "y", cone=octagon, equilibrium_only=True)),
        Case("dome with oculus, exact cone: tilt [deg]", "none", float("nan"), 0.0,
             partial(tilt, dome(), 0.6, "y", scan=2)),
        Case("hemispherical dome, by lune: least t/R", "Heyman 1967: 0.042", 0.0428, 5e-4,
             lambda: limit_thickness(partial(lune, rings=60), 0.05, 0.035, find=slippery_walls,
                                     options=LimitOptions(width=5e-5, scan=2))),
        Case("wall 1, friction 0.65, pushed sideways: load factor", "Ferris, Tin-Loi 2001",
             0.64286, 1e-4, partial(pushed_wall, 1)),
        Case("wall 2, friction 0.65, pushed sideways: load factor", "Ferris, Tin-Loi 2001",
             0.58000, 1e-4, partial(pushed_wall, 2)),
    ]  # fmt: skip


def shown(bracket: Bracket | None) -> str:
    """Both sides, to a tenth of what lies between them."""
    if bracket is None:
        return "not asked"
    if bracket.stands is None:
        return "nowhere"
    if bracket.falls is None:
        return f"{bracket.stands:.5g} and more"
    apart = abs(bracket.falls - bracket.stands)
    digits = max(1, int(np.ceil(-np.log10(apart) - 1e-6)) + 1)
    return f"{bracket.stands:.{digits}f} .. {bracket.falls:.{digits}f}"


def row(case: Case) -> tuple[str, bool]:
    began = time.thread_time()
    limit = case.find()
    spent = time.thread_time() - began
    value = limit.equilibrium.value
    off = abs(value - case.known) if value is not None else float("nan")
    held = not off > case.tolerance
    known = "" if np.isnan(case.known) else f"{case.known:g}"
    apart = "" if np.isnan(off) else f"{off:.1e}"
    line = (
        f"| {case.name} | {case.source} | {known} | {shown(limit.equilibrium)} | {apart} "
        f"| {shown(limit.uniform)} | {shown(limit.rest)} | {spent:.1f} |"
    )
    return line, held


def sweeps() -> list[str]:
    """The polar sweep of an arch with one and with two workers."""
    assembly = arch(0.15)
    contacts = joints(assembly, float(np.tan(np.deg2rad(43.0))))
    began, cpu = time.perf_counter(), time.process_time()
    alone = tilt_sweep(Model(assembly, contacts), 16)
    one, busy = time.perf_counter() - began, time.process_time() - cpu
    with ProcessPoolExecutor(2) as executor:
        list(executor.map(abs, (1, 2)))  # the processes have started
        began = time.perf_counter()
        together = tilt_sweep(Model(assembly, contacts), 16, executor=executor)
        two = time.perf_counter() - began
    same = np.array_equal(alone.rest, together.rest) and np.array_equal(
        alone.equilibrium, together.equilibrium
    )
    if not same:
        raise SystemExit("one and two workers disagree")
    return [
        f"Polar sweep of the arch (36 voussoirs, 43 degrees of friction), 16 directions: {one:.1f} "
        f"s with one worker ({busy:.1f} CPU s), {two:.1f} s with two, the same numbers to the "
        f"last bit. Weakest towards {alone.azimuth[alone.weakest]:g} degrees: "
        f"{np.nanmin(alone.rest):.2f} degrees.",
    ]


def real(path: str) -> list[str]:
    """Least friction and tilt limit of a model file."""
    assembly = supports.select(io.read(path).assembly, "lowest")
    contacts = joints(assembly, 0.84)
    lines = [f"{Path(path).name}, {len(assembly)} blocks, {contacts.count} joints:", ""]
    for name, find in (
        ("tilt about x [deg]", lambda: limit_tilt(Model(assembly, contacts), "x")),
        ("least friction", lambda: limit_friction(Model(assembly, contacts))),
    ):
        began, cpu = time.perf_counter(), time.process_time()
        limit = find()
        spent, busy = time.perf_counter() - began, time.process_time() - cpu
        lines.append(
            f"- {name}: balances {shown(limit.equilibrium)}, uniform stiffness "
            f"{shown(limit.uniform)}, stands {shown(limit.rest)}; {spent:.1f} s "
            f"({busy:.1f} CPU s), {len(limit.evaluations)} verdicts"
        )
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", help="a model file to time")
    arguments = parser.parse_args()
    lines = [
        f"| limit | source | known | balances | apart | uniform | stands | {CPU_NOTE} |",
        "|---|---|---|---|---|---|---|---|",
    ]
    failed = []
    for case in cases():
        line, held = row(case)
        print(line, flush=True)
        lines.append(line)
        if not held:
            failed.append(case.name)
    told = [*sweeps(), ""]
    if arguments.model is not None:
        told += [*real(arguments.model), ""]
    told.append(
        f"drystone {drystone.__version__}, Python {platform.python_version()}, "
        f"numpy {np.__version__}, {platform.machine()}, one thread unless said otherwise."
    )
    print("\n".join(told))
    write_table(TABLES / "limits.csv", lines)
    if failed:
        print(f"NOT HELD: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
