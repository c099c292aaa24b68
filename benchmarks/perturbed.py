"""Drawings that are a little off, beside their exact ones: ``python -m benchmarks.perturbed``.

Models whose smallest block has 0.1 m, as they are and with loads that make them fall, are perturbed
at random: every vertex by up to 0.2 % of its block, every free block shifted by up to 1 mm and
turned by up to 0.2 degrees, both together; with ``--simulated`` also the states in which MuJoCo
lets them rest, blocks in each other. ``--each N`` perturbs each N times, ``--only NAME`` one model.

An exact model stands with a margin if it stands with its load turned by :data:`MARGIN` in each of
four directions, and clearly falls if it falls so. Exit code 1 unless of those that stand with a
margin at least :data:`STABLE` are STABLE and none is UNSTABLE, and none of those that clearly fall
is STABLE.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone import Assembly, Block, Model, Verdict, check, models
from drystone.base.arrays import Floats
from drystone.geometry.frames import rotation_about
from drystone.io.mjcf import mjcf_text
from drystone.models import box

SIZE = 0.1
"""[m], size of the smallest block of each model but the table: 6 V / A."""
VERTEX = 0.002
"""Largest change of a coordinate by the size of the block."""
SHIFT, TURN = 1e-3, 0.2
"""[m] along each axis, and [deg]."""
MARGIN = 0.05
"""By how much loads are turned, horizontal by vertical."""
STABLE = 0.98
SIMULATED = 2.0
"""[s] that the simulator lets blocks settle."""
RESTS = 2e-3
"""[m], farthest that blocks of a simulated model move and count as at rest where they were."""
TOWARDS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))


@dataclass(frozen=True)
class Case:
    """An exact model, and the load on it: horizontal by vertical."""

    name: str
    assembly: Assembly
    lean: tuple[float, float] = (0.0, 0.0)
    friction: float = 0.6

    def model(
        self, assembly: Assembly | None = None, more: tuple[float, float] = (0.0, 0.0)
    ) -> Model:
        """The model, or one of the same blocks drawn otherwise, with a load turned further."""
        blocks = self.assembly if assembly is None else assembly
        x, y = self.lean[0] + more[0], self.lean[1] + more[1]
        return Model.of(blocks, friction=self.friction, load=(9.81 * x, 9.81 * y, -9.81))


def table() -> Assembly:
    """A seat of 30 mm on four legs of 40 mm."""
    legs = [
        box((0.04, 0.04, 0.45), (x, y, 0.0), name=f"leg {x} {y}")
        for x in (-0.19, 0.15)
        for y in (-0.19, 0.15)
    ]
    floor = box((2.0, 2.0, 0.1), (-1.0, -1.0, -0.1), name="floor")
    seat = box((0.4, 0.4, 0.03), (-0.2, -0.2, 0.45), name="seat")
    return Assembly((floor, *legs, seat)).with_fixed(["floor"])


def scaled(assembly: Assembly) -> Assembly:
    """The model whose smallest block has :data:`SIZE`, 6 V / A with its volume and surface."""
    area = np.linalg.norm(assembly.faces.area_vectors, axis=1)
    size = 6.0 * assembly.volume / np.bincount(assembly.faces.owner, area)
    return assembly.transformed(SIZE / float(size.min()) * np.eye(3))


def cases() -> list[Case]:
    """Exact models; of each, some loads under which it stands and some under which it falls.

    Blocks between flush faces, as in the h model, are left out: the least taper holds them.
    """
    made: dict[str, tuple[Assembly, tuple[float, ...]]] = {
        "table": (table(), (0.0, 0.3, 0.9)),
        "tower": (scaled(models.tower(5)), (0.0, 0.1, 0.5)),
        "wall": (scaled(models.wall(6, 5)), (0.0, 0.15, 0.8)),
        "toothed wall": (scaled(models.wall(5, 5, bond="toothed")), (0.0, 0.1, 0.8)),
        "arch": (scaled(models.arch(0.16)), (0.0, 0.05, 0.6)),
        "thin arch": (scaled(models.arch(0.08)), (0.0,)),
        "buttressed arch": (scaled(models.buttressed_arch()), (0.0, 0.6)),
        "vault": (scaled(models.barrel_vault()), (0.0, 0.6)),
        "stool": (scaled(models.stool()), (0.0, 0.1, 0.7)),
        "overhang": (scaled(models.overhang([0.2, 0.15, 0.1])), (0.0, 0.7)),
        "too far over": (scaled(models.overhang([0.4, 0.35, 0.3])), (0.0,)),
        "corbelled wall": (scaled(models.corbelled_wall()), (0.0, 0.7)),
        "a": (scaled(models.a_model()), (0.0, 0.8)),
        "pile": (scaled(models.random_pack(12, seed=1)), (0.0, 0.7)),
        "dovetail": (scaled(models.dovetail()), (0.0,)),
        "shelf": (scaled(models.shelf()), (0.0, 0.6)),
        "bridge": (scaled(models.bridge()), (0.0, 0.7)),
    }
    return [
        Case(f"{name} {lean:g}" if lean else name, assembly, (lean, 0.3 * lean))
        for name, (assembly, leans) in made.items()
        for lean in leans
    ]


def clearly(case: Case) -> Verdict:
    """The verdict that all turned loads agree on; UNDECIDED where they do not."""
    verdict = check(case.model()).verdict
    for x, y in TOWARDS:
        if check(case.model(more=(MARGIN * x, MARGIN * y))).verdict is not verdict:
            return Verdict.UNDECIDED
    return verdict


def by_vertex(assembly: Assembly, rng: np.random.Generator) -> Assembly:
    """Every vertex moved by up to :data:`VERTEX` of its block."""
    blocks = []
    for block, volume in zip(assembly.blocks, assembly.volume, strict=True):
        most = VERTEX * float(np.cbrt(volume))
        moved = block.vertices + rng.uniform(-most, most, block.vertices.shape)
        blocks.append(Block(moved, block.faces, block.name, density=block.density))
    return Assembly(tuple(blocks)).with_fixed(np.flatnonzero(assembly.fixed).tolist())


def by_pose(assembly: Assembly, rng: np.random.Generator) -> Assembly:
    """Every free block shifted by up to :data:`SHIFT` and turned by up to :data:`TURN`."""
    blocks = []
    for block, middle, fixed in zip(
        assembly.blocks, assembly.centroid, assembly.fixed, strict=True
    ):
        axis = rng.normal(size=3)
        turn = rotation_about(axis / np.linalg.norm(axis), rng.uniform(-TURN, TURN))
        shift = rng.uniform(-SHIFT, SHIFT, 3)
        blocks.append(block if fixed else block.transformed(turn, middle - turn @ middle + shift))
    return Assembly(tuple(blocks)).with_fixed(np.flatnonzero(assembly.fixed).tolist())


def by_both(assembly: Assembly, rng: np.random.Generator) -> Assembly:
    """Vertices moved, then blocks."""
    return by_pose(by_vertex(assembly, rng), rng)


KINDS: dict[str, Callable[[Assembly, np.random.Generator], Assembly]] = {
    "vertices": by_vertex,
    "poses": by_pose,
    "both": by_both,
}


def simulated(case: Case) -> Assembly:
    """The blocks where MuJoCo lets them rest under the load."""
    import mujoco  # optional: the simulator is asked for by name

    model: Any = mujoco.MjModel.from_xml_string(mjcf_text(case.model()))
    data: Any = mujoco.MjData(model)
    model.opt.gravity[:] = 9.81 * case.lean[0], 9.81 * case.lean[1], -9.81
    begin: Floats | None = None
    for _ in range(int(SIMULATED / model.opt.timestep)):
        if begin is None:
            mujoco.mj_forward(model, data)
            begin = data.xpos.copy()
            turned = data.xmat.reshape(-1, 3, 3).copy()
        mujoco.mj_step(model, data)
    assert begin is not None
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, i) for i in range(model.nbody)]
    blocks = []
    for block, fixed in zip(case.assembly.blocks, case.assembly.fixed, strict=True):
        if fixed or block.name not in names:
            blocks.append(block)
            continue
        i = names.index(block.name)
        turn = data.xmat.reshape(-1, 3, 3)[i] @ turned[i].T
        blocks.append(block.transformed(turn, data.xpos[i] - turn @ begin[i]))
    return Assembly(tuple(blocks)).with_fixed(np.flatnonzero(case.assembly.fixed).tolist())


def drawings(case: Case, each: int, simulate: bool) -> Iterator[tuple[str, Assembly]]:
    """The perturbed drawings of a case by their kinds; the seed is the same every time."""
    for number in range(each):
        for kind, perturb in KINDS.items():
            rng = np.random.default_rng([number, *case.name.encode(), *kind.encode()])
            yield kind, perturb(case.assembly, rng)
    if simulate:
        rests = simulated(case)
        moved = np.linalg.norm(rests.centroid - case.assembly.centroid, axis=1).max()
        if moved < RESTS:  # otherwise it has slid or fallen, and is another model
            yield "simulated", rests


def main(arguments: list[str] | None = None) -> int:
    """Print a line for each drawing that is not answered as its exact one, and the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--each", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--simulated", action="store_true")
    asked = parser.parse_args(arguments)
    counts: Counter[tuple[Verdict, Verdict]] = Counter()
    begin = time.process_time()
    for case in cases():
        if asked.only not in case.name:
            continue
        truth = clearly(case)
        print(f"{case.name}: {truth}", flush=True)
        if truth is Verdict.UNDECIDED:
            continue
        for kind, assembly in drawings(case, asked.each, asked.simulated):
            found = check(case.model(assembly))
            counts[truth, found.verdict] += 1
            if found.verdict is not truth:
                print(f"  {kind}: {found.verdict}, {found.message}", flush=True)
    return _judged(counts, time.process_time() - begin)


def _judged(counts: Counter[tuple[Verdict, Verdict]], seconds: float) -> int:
    stands = {verdict: counts[Verdict.STABLE, verdict] for verdict in Verdict}
    falls = {verdict: counts[Verdict.UNSTABLE, verdict] for verdict in Verdict}
    for words, each in (("stand with a margin", stands), ("clearly fall", falls)):
        told = ", ".join(f"{number} {verdict}" for verdict, number in each.items() if number)
        print(f"{sum(each.values())} drawings of models that {words}: {told or 'none'}")
    print(f"{seconds:.0f} CPU s")
    wrong = stands[Verdict.UNSTABLE] or falls[Verdict.STABLE]
    few = stands[Verdict.STABLE] < STABLE * sum(stands.values())
    return 1 if wrong or few else 0


if __name__ == "__main__":
    sys.exit(main())
