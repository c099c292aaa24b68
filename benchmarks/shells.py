"""Four shells at three sizes, what they stand, and the wedge: ``python -m benchmarks.shells``.

Correctness first: a shell whose blocks do not fit stops the run. Each part (build, stand, wedge)
writes its table, docs/trust/tables/shells-PART.csv, and the wedge its plot.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.sample_shells import SAMPLES, sample_shell
from benchmarks.tables import TABLES, write_table
from drystone import Assembly, CheckOptions, Contacts, LoadCase, Verdict
from drystone.detection import DetectionOptions, find_contacts
from drystone.geometry.surface import edge_defects
from drystone.limits import LimitOptions, limit_friction, limit_tilt
from drystone.model import Model
from drystone.shells import (
    Edge,
    Ground,
    Layout,
    Shape,
    Shell,
    ShellBody,
    Side,
    build_shell,
    patch_from_function,
    rectangular_plan,
    shape_volume,
)
from drystone.stability import check

DOCS = Path(__file__).parents[1] / "docs"
PLOT = DOCS / "images" / "shells-wedge.svg"
TIGHTEST = DetectionOptions(gap=1e-6)
SIZES = (40, 400, 4000)
WEDGES = (0.0, 0.1, 0.2, 0.3, 0.4)
FRICTIONS = (0.6, 0.84)
MOST_FRICTION = 2.0
"""With which the flat plan is tried too."""
UNIFORM = CheckOptions(samples=0, settle=False)
PRECISION = {40: (0.25, 0.01), 400: (1.0, 0.02)}
"""Of limits of tilt [degrees] and of friction, by size; larger shells are only built."""


@dataclass(frozen=True)
class Built:
    """A sample whose blocks fit, and its row of the table."""

    kind: str
    size: int
    shell: Shell
    contacts: Contacts
    row: str


def areas_by_pair(shell: Shell, contacts: Contacts) -> float:
    """Largest difference of the area of a pair's joints from that of its shared faces, relative.

    Raises
    ------
    AssertionError
        Detection found other pairs than share a face.
    """
    made: dict[frozenset[int], float] = {}
    for joint in shell.contacts:
        pair = frozenset(joint.blocks)
        made[pair] = made.get(pair, 0.0) + joint.area
    found: dict[frozenset[int], float] = {}
    for a, b, area in zip(
        contacts.block_a.tolist(), contacts.block_b.tolist(), contacts.area.tolist(), strict=True
    ):
        found[frozenset((a, b))] = found.get(frozenset((a, b)), 0.0) + area
    assert set(found) == set(made), "detection found other pairs than share a face"
    return max(abs(found[pair] - area) / area for pair, area in made.items())


def built(kind: str, size: int) -> Built:
    """A sample, its gate passed."""
    start = time.process_time()
    shell = sample_shell(kind, size)
    build = time.process_time() - start
    start = time.process_time()
    found = find_contacts(shell.assembly, options=TIGHTEST)
    detect = time.process_time() - start
    error = areas_by_pair(shell, found.contacts)
    ratio = shell.volume / shape_volume(shell.shape, SAMPLES[kind][size][1])
    for block in shell.assembly.blocks:
        assert edge_defects(block.faces) == ([], [], True), block.name
        assert block.volume > 0.0, block.name
        assert not block.repairs, block.name
    assert not found.report.overlaps
    assert shell.planar.warp_after <= 1e-6
    assert error <= 1e-6
    assert abs(ratio - 1.0) <= 0.01
    row = (
        f"| {kind} | {len(shell.voussoirs):,} | {len(found.contacts.area):,} | {build:.2f} | "
        f"{detect:.2f} | {shell.planar.warp_before:.1e} | {shell.planar.warp_after:.0e} | "
        f"{shell.planar.drift:.2f} | {shell.off_surface:.2f} | {shell.fitted:.3f} | "
        f"{error:.0e} | {ratio:.4f} |"
    )
    print(row, flush=True)
    return Built(kind, size, shell, found.contacts, row)


def last_true(stands: Callable[[float], bool], low: float, high: float, width: float) -> float:
    """Where ``stands`` ends, by bisection from ``low``, where it holds, towards ``high``."""
    if stands(high):
        return high
    while abs(high - low) > width:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stands(middle) else (low, middle)
    return low


def limits(built: Built) -> str:
    """Verdict, and largest tilt about x and y and least friction: balanced, and standing."""
    assembly, contacts = built.shell.assembly, built.contacts
    start = time.process_time()
    result = check(Model(assembly, contacts))
    cost = time.process_time() - start
    degrees, coefficient = PRECISION[built.size]

    def tilt(axis: str) -> str:
        vector = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0)}[axis]

        def stands(angle: float) -> bool:
            return _stands(assembly, contacts, LoadCase.tilt(assembly, vector, angle), UNIFORM)

        options = LimitOptions(equilibrium_only=True, width=degrees)
        bound = limit_tilt(Model(assembly, contacts), axis, options=options).equilibrium.stands
        return f"{last_true(stands, 0.0, bound, degrees):.1f} / {bound:.1f}"

    def at(friction: float) -> bool:
        return _stands(assembly, contacts.with_friction(friction), None, UNIFORM)

    options = LimitOptions(equilibrium_only=True, width=coefficient)
    bound = limit_friction(Model(assembly, contacts), options=options).equilibrium.stands
    least = f"{last_true(at, 0.6, bound, coefficient):.2f} / {bound:.2f}"
    cells = f"{tilt('x')} | {tilt('y')} | {least}"
    tried = f" ({result.samples.standing} of {result.samples.tried})"
    stable = result.verdict is Verdict.STABLE
    row = (
        f"| {built.kind} | {len(built.shell.voussoirs):,} | {result.verdict.value}"
        f"{tried if stable else ''} | {cells} | {cost:.1f} |"
    )
    print(row, flush=True)
    return row


def _stands(
    assembly: Assembly, contacts: Contacts, load: LoadCase | None, options: CheckOptions
) -> bool:
    return check(Model(assembly, contacts, load), options=options).verdict is Verdict.STABLE


def flat(size: int) -> str:
    """The plan of the form-found shell, left flat."""
    layout = SAMPLES["form-found"][size][0]
    shell = build_shell(rectangular_plan(6.0, 5.0), layout, ShellBody(thickness=0.2))
    contacts = find_contacts(shell.assembly, options=TIGHTEST).contacts
    start = time.process_time()
    verdict = check(Model(shell.assembly, contacts)).verdict
    cost = time.process_time() - start
    assert verdict is Verdict.UNSTABLE
    most = _stands(shell.assembly, contacts.with_friction(MOST_FRICTION), None, UNIFORM)
    none = f"none up to {MOST_FRICTION:g}" if not most else f"between 0.6 and {MOST_FRICTION:g}"
    row = (
        f"| its plan, flat | {len(shell.voussoirs)} | {verdict.value} | falls at 0 | falls at 0 | "
        f"{none} | {cost:.1f} |"
    )
    print(row, flush=True)
    return row


def lean(wedge: float, friction: float, options: CheckOptions) -> float:
    """Largest lean [degrees] at which one block stands alone on the course below.

    A straight wall, blocks 0.6 m long, 0.4 m high and 0.2 m thick.
    """
    patch = patch_from_function(
        lambda u, v: np.stack([3.0 * v, 0.0 * u, 0.8 * u], axis=-1), name="wall"
    )
    shape = Shape((patch,), supports=(Edge(0, Side.BOTTOM),))
    body = ShellBody(thickness=0.2, ground=Ground.SPRINGERS)
    shell = build_shell(shape, Layout(courses=2, blocks=5, wedge=wedge), body)
    below = [name for name in shell.assembly.names if name.startswith("c00")]
    assembly = shell.assembly.subset([*below, "c01-b02"])
    contacts = find_contacts(assembly, friction=friction, options=TIGHTEST).contacts

    def stands(angle: float) -> bool:
        return _stands(assembly, contacts, LoadCase.tilt(assembly, (1, 0, 0), angle), options)

    return last_true(stands, 0.0, 80.0, 0.1)


def build_part(sizes: list[int]) -> list[str]:
    """Four shells at each size."""
    rows = [built(kind, size).row for size in sizes for kind in SAMPLES]
    return [
        "| shell | voussoirs | joints | build [s] | detect [s] | warp before | warp after | drift "
        "| off | moved | area | volume |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
        *rows,
    ]


def stand_part(sizes: list[int]) -> list[str]:
    """Verdicts and limits."""
    searched = [size for size in sizes if size in PRECISION]
    rows = [limits(built(kind, size)) for size in searched for kind in SAMPLES]
    rows += [flat(size) for size in searched]
    return [
        "| shell | voussoirs | stands (contact stiffnesses) | tilt about x [deg] "
        "| about y [deg] | least friction | verdict [s] |",
        "|---|---|---|---|---|---|---|",
        *rows,
    ]


def wedge_part(_: list[int]) -> list[str]:
    """The lean of a block against its wedge, and the plot."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "drystone"
    import matplotlib.pyplot as plt

    cases = [(mu, options) for mu in FRICTIONS for options in (UNIFORM, CheckOptions())]
    titles = [
        f"friction {mu}, {'uniform stiffness' if options is UNIFORM else 'check'}"
        for mu, options in cases
    ]
    leans = [[lean(wedge, mu, options) for wedge in WEDGES] for mu, options in cases]
    figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
    for values, title, style in zip(leans, titles, ("C0o-", "C0o--", "C1s-", "C1s--"), strict=True):
        axes.plot(WEDGES, values, style, label=title)
    axes.set(xlabel="wedge, by the height of a course", ylabel="largest lean [degrees]")
    axes.legend()
    PLOT.parent.mkdir(exist_ok=True)
    figure.savefig(PLOT, metadata={"Date": None})
    plt.close(figure)
    rows = [
        f"| {wedge:.1f} | " + " | ".join(f"{values[i]:.1f}" for values in leans) + " |"
        for i, wedge in enumerate(WEDGES)
    ]
    print("\n".join(rows), flush=True)
    return [
        "| wedge | " + " | ".join(titles) + " |",
        "|---|" + "---|" * len(titles),
        *rows,
    ]


PARTS = {"build": build_part, "stand": stand_part, "wedge": wedge_part}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; all when left out")
    parser.add_argument("--sizes", type=int, nargs="*", default=list(SIZES))
    arguments = parser.parse_args()
    for part in arguments.parts or PARTS:
        write_table(TABLES / f"shells-{part}.csv", PARTS[part](arguments.sizes))


if __name__ == "__main__":
    main()
