"""Limits that others publish with sizes and friction, on both sides of each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.field import lact3
from benchmarks.field.ferris import WALLS
from drystone import Assembly, Block, CheckOptions, LoadCase, Model, check, io, solve_rbe
from drystone.models import prism
from drystone.programs import RBEOptions

FIELD = Path(__file__).parents[2] / "benchmarks" / "field" / "models"


def toppling_slope() -> Assembly:
    """Sixteen blocks, 10 m wide, on steps of 1 m of a base that dips by 30 degrees.

    The face is cut at 56.6 degrees, the layers dip into it by 60: the heights grow by 4 m a block
    up to the crest, 40 m at the tenth, and decrease by 6 m behind it.
    """
    wide, step, lean = 10.0, 1.0, np.deg2rad(30.0)
    heights = [*np.arange(4.0, 41.0, 4.0), *np.arange(34.0, 3.0, -6.0)]
    turn = np.array([[np.cos(lean), np.sin(lean)], [-np.sin(lean), np.cos(lean)]])
    treads: list[tuple[float, float]] = []
    blocks: list[Block] = []
    for i, height in enumerate(heights):
        left, right, low = wide * i, wide * (i + 1), step * i
        treads += [(left, low), (right, low)]
        outline = [(left, low), (right, low), (right, low + height), (left, low + height)]
        blocks.append(prism(np.array(outline) @ turn, (0.0, 10.0), f"block-{i + 1}"))
    rock = np.array([(0.0, -30.0), *treads, (wide * len(heights), -30.0)])
    return Assembly((prism(rock @ turn, (0.0, 10.0), "rock"), *blocks)).with_fixed([0])


@pytest.mark.parametrize(("degrees", "stands"), [(37.9, False), (38.4, True)])
def test_a_slope_of_sixteen_blocks_topples_below_a_friction_of_38_15_degrees(
    degrees: float, stands: bool
) -> None:
    """Goodman and Bray 1976, "Toppling of rock slopes": the example of limiting equilibrium.

    Of the sixteen blocks those at the toe slide, those behind them topple and the last three stand.
    Some forces balance the loads below this friction too, which nothing brings about.
    """
    model = Model.of(toppling_slope(), friction=float(np.tan(np.deg2rad(degrees))))
    assert not solve_rbe(model, options=RBEOptions.feasibility()).falls
    found = check(model, options=CheckOptions(stiff_shear=None))
    assert found.stable is stands
    assert found.falls is not stands
    assert found.falling_names == (
        () if stands else tuple(f"block-{number}" for number in range(1, 14))
    )


@pytest.mark.parametrize("name", ["portal", "wall", "arch"])
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_tilting_tables_of_lact3(name: str, share: float) -> None:
    """Hua and others 2025, LACT3 1.0: the tilt at which no forces balance the loads any more."""
    angle, friction = lact3.ANGLES[name]
    blocks = io.read(FIELD / f"lact3-{name}.json").assembly
    model = Model.of(
        blocks,
        friction=float(np.tan(np.deg2rad(friction))),
        load=LoadCase.tilt(blocks, (0.0, 1.0, 0.0), share * angle),
    )
    found = solve_rbe(model, options=RBEOptions.feasibility())
    assert found.falls is (share > 1.0)


@pytest.mark.parametrize("number", [3, 4, 5])
@pytest.mark.parametrize("share", [0.999, 1.001])
def test_walls_of_ferris_and_tin_loi_with_openings(number: int, share: float) -> None:
    """Ferris and Tin-Loi 2001, as programs that cite it quote them: associated load factors."""
    blocks = io.read(FIELD / f"ferris-{number}.json").assembly
    push = LoadCase.gravity(blocks) + share * WALLS[number].associated * LoadCase.seismic(
        blocks, 1.0
    )
    model = Model.of(blocks, friction=0.65, load=push)
    assert solve_rbe(model, options=RBEOptions.feasibility()).falls is (share > 1.0)


@pytest.mark.parametrize("share", [0.35, 0.38])
def test_the_arch_of_oppenheim_under_a_horizontal_acceleration(share: float) -> None:
    """Oppenheim 1992: four hinges at 0.37 g."""
    blocks = io.read(FIELD / "oppenheim.json").assembly
    push = LoadCase.gravity(blocks) + LoadCase.seismic(blocks, share)
    found = check(Model.of(blocks, friction=2.0, load=push))
    assert found.stable is (share < 0.37)
