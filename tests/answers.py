"""One answer of each kind, made once for all tests that look at every kind."""

import functools
import tempfile
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import drystone
from benchmarks.sample_shells import sample_shell
from drystone import Model, design, limits, seismic, sequence, shells, studies
from drystone.answer import Answer
from drystone.fall import Film
from drystone.io import Inspection
from drystone.models import arch, box, tower
from drystone.reproduce import reproduce

RARE = Model.of(tower(2), friction=0.0).with_load((1.0, 0.0, -9.81))
SPECTRUM = seismic.Spectrum.ec8(1.0, "A")


def answers() -> Iterator[Answer]:
    """One of each."""
    stack = Model.of(tower(3), friction=0.6)
    yield drystone.check(stack)
    yield drystone.diagnose(arch(0.06, 6), friction=0.9)
    coarse = limits.LimitOptions(width=5.0, scan=1)
    yield limits.limit_tilt(stack, options=coarse)
    yield limits.tilt_sweep(stack, 2, options=coarse)
    yield limits.limit_train(arch(0.3, 8), steps=1, friction=0.8)
    yield limits.thrust_bounds(stack, "block-0", (0.0, 0.0, 1.0))
    yield drystone.programs.find_forces(stack)
    yield from (sequence.interlocking(stack), sequence.gravity_region(stack, directions=4))
    file = Path(tempfile.mkdtemp()) / "cases.toml"
    file.write_text('situations = ["EQU"]\n[case.gravity]\nkind = "permanent"', encoding="utf-8")
    yield studies.combinations(stack, file)
    yield limits.imperfections(stack, limits.Imperfections(offset=0.01), draws=2)
    yield drystone.settle(tower(2))
    yield seismic.local_mechanism(tower(2), part="block-1", site=seismic.SeismicDemand(SPECTRUM))
    yield drystone.settlement.push(tower(2), friction=0.3, to=0.01)
    moves = {"springer-right": (0.01, 0.0, 0.0)}
    yield drystone.settlement.support_response(arch(0.2, 8), moves, friction=0.9)
    yield drystone.find_poses(box((1.0, 2.0, 3.0)))
    yield Film(Model.of(tower(2)), np.zeros(1), np.zeros((1, 2, 6)), True)
    order = drystone.plan(stack)
    yield from (order, sequence.scaffolding(order))
    robots = [sequence.Robot("left"), sequence.Robot("right")]
    yield from (sequence.handling(order, robots[:1]), sequence.take_turns(stack, robots=robots))
    yield sequence.margins(order, tilt_width=5.0, directions=1)
    with TemporaryDirectory() as folder:
        yield sequence.dataset([stack], folder, options=sequence.DatasetOptions(rows=2))
    yield sequence.sweep_friction(stack, [0.6], drystone.plan)
    yield reproduce("5.1.1")
    found = drystone.find_contacts(tower(3))
    yield Inspection(tower(3), found)
    few = design.MendOptions(kinds=("friction", "ballast"))
    mends = design.find_mends(RARE, options=few)
    yield from (mends, mends.mends[0])
    yield from (design.sharpen(tower(2)), design.recut_joints(tower(2)))
    still = design.block_moves(RARE, ["block-1"], (1.0, 0.0, 0.0), 0.1)
    yield design.shape(tower(2), still)
    yield design.Changed.by_hand(stack, drystone.check(stack), "nothing")
    yield design.cut_until_free(box((1.0, 1.0, 2.0)), options=design.CutOptions(blocks=2))
    shell = sample_shell("barrel")
    yield shell
    eye, layout = shells.dome(3.0, 2.0), shells.Layout(courses=2, blocks=4)
    yield design.make_buildable(eye, layout, shells.ShellBody(thickness=0.5))
    count = [design.Parameter("count", choices=(2, 3))]
    yield design.tune(tower, count, options=design.TuneOptions(trials=1))


@functools.cache
def one_of_each() -> dict[type[Answer], Answer]:
    """By their class."""
    return {type(one): one for one in answers()}
