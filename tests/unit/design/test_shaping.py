"""Shape by gradient: true derivatives, known optima, and shapes checked again from their files."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import Assembly, InputError, LoadCase, Model
from drystone.base.arrays import Floats
from drystone.cli import main
from drystone.design import (
    DesignMargin,
    FamilyMoves,
    ShapeOptions,
    block_moves,
    free_vertices,
    joint_moves,
    shape,
    thickening,
)
from drystone.design.corner_following import Corners
from drystone.design.needs import Form
from drystone.design.vertex_places import BlockVertices
from drystone.models import arch, box, concave, dome, prism, shelf, tower
from drystone.shells.shell_families import shell_by_name


def stack(bricks: int) -> Model:
    """Bricks of 1 m, one on the other, the lowest one fixed."""
    blocks = [box((1.0, 0.5, 0.25), (0.0, 0.0, 0.25 * i), f"brick-{i}") for i in range(bricks + 1)]
    return Model.of(Assembly(tuple(blocks)).with_fixed([0]), friction=0.6)


def flat_arch() -> Model:
    """Three cubes between two fixed ones: forces could balance them, but nothing presses."""
    blocks = [box((1.0, 1.0, 1.0), (float(i), 0.0, 0.0), f"block-{i}") for i in range(5)]
    return Model.of(Assembly(tuple(blocks)).with_fixed([0, 4]), friction=0.5)


def pushed_plank() -> Model:
    """The concave plank without friction, pushed out of its slab."""
    model = Model.of(concave("short"), friction=0.0)
    push = LoadCase.point_load(model.assembly, "plank", (4e3, 1e3, 0.0), (0.9, 0.0, 0.0))
    return model.with_load(LoadCase.gravity(model.assembly) + push)


def staggered() -> Model:
    """Blocks turned on each other, so that joints have corners where edges cross."""
    blocks = [tower(3).blocks[0]]
    for i, block in enumerate(tower(3).blocks[1:], 1):
        blocks.append(block.transformed(translation=(0.2 * i, 0.1 * i, 0.0)))
    leaning = Model.of(Assembly(tuple(blocks)).with_fixed([0]), friction=0.5)
    return leaning.with_load((3.0, 1.0, -9.81))


@pytest.mark.parametrize(
    "model",
    [
        Model.of(arch(0.08, 8), friction=0.7),
        Model.of(shelf(), friction=0.9),
        Model.of(dome(), friction=0.3).with_load((4.0, 1.0, -9.81)),
        Model.of(concave("short"), friction=0.3).with_load((5.0, 1.0, -9.81)),
        staggered(),
    ],
    ids=["arch", "shelf", "dome", "concave plank", "staggered"],
)
@pytest.mark.parametrize("each", [True, False])
def test_the_gradient_is_that_of_central_differences(model: Model, each: bool) -> None:
    form = Form.of(model, ground=1e-3, glue=1.0, each=each)
    vertex = form.bodies.vertex
    way = together(vertex, np.random.default_rng(0))  # no joint is torn apart
    _, gradient = form.help_at(vertex)
    step = 1e-7 * float(np.ptp(vertex, axis=0).max())
    ahead, behind = form.help_at(vertex + step * way)[0], form.help_at(vertex - step * way)[0]
    slope = (ahead - behind) / (2.0 * step)
    assert float((gradient * way).sum()) == pytest.approx(slope, rel=1e-5)


def together(vertex: Floats, rng: np.random.Generator) -> Floats:
    """A random way for each place."""
    size = float(np.ptp(vertex, axis=0).max())
    place = np.unique(np.round(vertex / (1e-6 * size)), axis=0, return_inverse=True)[1]
    return rng.normal(size=vertex.shape)[place.ravel()]


def test_an_arch_gets_as_thin_as_it_stands(tmp_path: Path) -> None:
    found = shape(
        arch(0.2, 12),
        lambda model: thickening(model, (0.0, 0.0, 0.0), 0.15),
        friction=0.8,
        options=ShapeOptions(aim="volume"),
    )
    thickness = 0.2 + found.x[0]
    assert found.stands
    assert found.value < found.first
    assert not drystone.check(arch(0.99 * thickness, 12), friction=0.8).stable
    path = tmp_path / "thin.json"
    drystone.write(found.model, path)
    assert drystone.check(drystone.read(path)).stable


def test_the_overhang_of_a_stack_is_the_harmonic_one() -> None:
    model = stack(2)
    found = shape(
        model,
        block_moves(model, ["brick-1", "brick-2"], (1.0, 0.0, 0.0), 1.5),
        options=ShapeOptions(aim="reach", block="brick-2", close=1e-4),
    )
    assert found.stands
    assert found.value - found.first == pytest.approx(0.5 + 0.25, rel=0.0005)


def test_a_thin_arch_is_shaped_until_it_stands_with_its_joints_shared() -> None:
    model = Model.of(arch(0.09, 8), friction=0.8)
    found = shape(model, free_vertices(model, 0.05, mirror="x"))
    assert found.stands
    assert found.value < 1e-4 < found.first  # what stands needs no help
    assert drystone.check(found.model).stable
    assert found.model.contacts.count == model.contacts.count
    assert (Form.of(found.model).corners.at >= 0).all()


@pytest.mark.parametrize(
    ("make", "mirror", "sectors"),
    [
        (lambda: Model.of(dome(slices=7, rings=3), friction=0.6), "y", 1),
        (lambda: Model.of(dome(slices=8, rings=3), friction=0.6), "y", 4),
        (lambda: Model.of(dome(slices=6, rings=3, bonded=True), friction=0.6), None, 1),
        (lambda: shell_by_name("barrel", courses=4, blocks=2, thickness=0.4).model(), None, 1),
        (lambda: shell_by_name("dome", courses=2, blocks=6, thickness=0.5).model(), None, 1),
    ],
    ids=["dome", "dome in sectors", "bonded dome", "barrel shell", "dome shell"],
)
def test_joints_of_domes_and_shells_stay_plane_and_shared(
    make: Callable[[], Model], mirror: str | None, sectors: int
) -> None:
    model = make()
    moves = free_vertices(model, 0.1, along=None, mirror=mirror, sectors=sectors)
    vertex = model.assembly.faces.point
    rng = np.random.default_rng(0)
    x = 0.02 * rng.uniform(-1.0, 1.0, moves.count)
    moved = moves.moved(vertex, x)
    assert np.abs(moved - vertex).max() > 0.005
    # what was at one place still is, and joints are where both blocks have plane faces
    size = float(np.ptp(vertex, axis=0).max())
    place = np.unique(np.round(vertex / (1e-6 * size)), axis=0, return_inverse=True)[1].ravel()
    first = np.unique(place, return_index=True)[1][place]
    assert np.array_equal((moved - vertex)[first], moved - vertex)
    corners = Corners.of(model, BlockVertices.of(model.assembly)).points(moved)
    start = model.contacts.start
    for i in range(model.contacts.count):
        corner = corners[start[i] : start[i + 1]]
        assert np.linalg.svd(corner - corner.mean(axis=0), compute_uv=False)[-1] < 1e-9
    # and the derivative is that of differences
    way = rng.normal(size=moves.count)
    ahead, behind = (moves.moved(vertex, x + step * way) for step in (1e-6, -1e-6))
    slope = (moves.matrix_at(x) @ way).reshape(-1, 3)
    assert slope == pytest.approx((ahead - behind) / 2e-6, abs=1e-6)


def test_a_dome_that_falls_is_shaped_until_it_stands(tmp_path: Path) -> None:
    """Tilted by 31 degrees, its rings slide on each other."""
    base = Model.of(dome(thickness=0.3, slices=6, rings=3), friction=0.3)
    base = base.with_load((6.0, 0.0, -9.81))
    assert not drystone.check(base).stable
    found = shape(base, free_vertices(base, 0.2, along=None, mirror="y"))
    assert found.stands
    path = tmp_path / "dome.json"
    drystone.write(found.model, path)
    again = drystone.read(path)
    assert drystone.check(again).stable
    assert again.contacts.count == base.contacts.count


def test_a_ring_of_equal_blocks_asks_for_its_symmetry() -> None:
    with pytest.raises(InputError, match="name its sectors, a mirror axis"):
        free_vertices(Model.of(dome(slices=8, rings=3), friction=0.6), 0.1, along=None)


def test_a_flat_arch_stands_once_its_joints_are_turned(tmp_path: Path) -> None:
    """Between vertical joints nothing presses on blocks; wedges press on each other."""
    model = flat_arch()
    found = shape(model, joint_moves(model, 0.3, mirror="x"))
    assert found.stands
    level = np.concatenate([block.vertices[:, 2] for block in found.model.assembly.blocks])
    assert set(np.round(level, 12)) == {0.0, 1.0}
    volume = found.model.assembly.volume.sum()
    assert volume == pytest.approx(model.assembly.volume.sum(), rel=1e-12)
    path = tmp_path / "flat.json"
    drystone.write(found.model, path)
    assert drystone.check(drystone.read(path)).stable


@pytest.mark.parametrize("size", [1.0, 0.1])
def test_a_block_that_falls_needs_the_same_help_when_it_is_small(size: float) -> None:
    """One of two blocks falls: the mean square of the shares of their loads is a half."""
    blocks = (
        box((3.0, 1.0, 0.2), (0.0, 0.0, -0.2), "floor"),
        box((1.0, 1.0, 1.0), (0.0, 0.0, 0.0), "stands"),
        box((size, size, size), (3.0, 0.0, -0.5 * size - 0.1), "falls"),
    )
    model = Model.of(Assembly(blocks).with_fixed([0]), friction=0.6)
    form = Form.of(model)
    assert form.help_at(form.bodies.vertex)[0] == pytest.approx(0.5, abs=0.01)


def test_the_shelf_is_shaped_until_it_stands_for_all_stiffnesses(tmp_path: Path) -> None:
    model = Model.of(shelf(), friction=0.9)
    options = ShapeOptions(least_edge=0.003)
    found = shape(model, free_vertices(model, 0.08), options=options)
    assert found.stands
    path = tmp_path / "shelf.json"
    drystone.write(found.model, path)
    again = drystone.check(drystone.read(path))
    assert again.stable
    assert again.samples.standing == again.samples.tried


@pytest.mark.parametrize("side", ["intrados", "extrados"])
def test_the_side_that_is_kept_stays(side: str) -> None:
    model = Model.of(arch(0.09, 8), friction=0.8)
    found = shape(model, free_vertices(model, 0.05, mirror="x", keep_side=side))
    assert found.stands
    before, after = (
        np.concatenate([block.vertices for block in one.assembly.blocks[1:-1]])
        for one in (model, found.model)
    )
    inner = np.hypot(before[:, 0], before[:, 2]) < 1.0
    moved = np.abs(after - before).max(axis=1) > 0.0
    assert not moved[inner == (side == "intrados")].any()
    assert moved.any()


def test_no_edge_gets_shorter_than_the_least() -> None:
    model = Model.of(arch(0.2, 6), friction=0.8)
    found = shape(
        model,
        free_vertices(model, 0.05, mirror="x"),
        options=ShapeOptions(aim="volume", least_edge=0.15, rounds=2, iterations=10),
    )
    contacts = found.model.contacts
    corner = contacts.polygon(contacts.count // 2)
    sides = np.linalg.norm(corner - np.roll(corner, 1, axis=0), axis=1)
    assert found.value < found.first
    assert sides.min() >= 0.15 - 1e-6
    with pytest.raises(InputError, match=r"an edge that moves is 0\.2 m long already"):
        shape(model, free_vertices(model, 0.05), options=ShapeOptions(least_edge=0.25))


def test_a_margin_makes_it_thicker() -> None:
    margin = DesignMargin(tilt=3.0)
    found = shape(
        arch(0.13, 8),
        lambda model: thickening(model, (0.0, 0.0, 0.0), 0.05),
        friction=0.8,
        options=ShapeOptions(aim="volume", margin=margin),
    )
    assert found.stands
    thinner = Model.of(arch(0.98 * (0.13 + float(found.x[0])), 8), friction=0.8)
    assert drystone.check(thinner).stable
    assert not margin.stands(thinner)


def test_a_family_is_shaped_as_its_vertices_are() -> None:
    options = ShapeOptions(aim="volume")
    model = Model.of(arch(0.2, 8), friction=0.8)
    moves = FamilyMoves.of(partial(arch, voussoirs=8), {"thickness_ratio": 0.2},
                           {"thickness_ratio": 0.15})  # fmt: skip
    by_family = shape(model, moves, options=options)
    by_vertices = shape(model, thickening(model, (0.0, 0.0, 0.0), 0.15), options=options)
    assert by_family.stands
    assert float(by_family.x[0]) == pytest.approx(float(by_vertices.x[0]), abs=2e-4)
    with pytest.raises(InputError, match="not those of the model"):
        shape(Model.of(arch(0.25, 8), friction=0.8), moves)
    with pytest.raises(InputError, match="keep the blocks"):
        shape(Model.of(arch(0.2, 6), friction=0.8), moves)
    with pytest.raises(InputError, match="differ"):
        FamilyMoves.of(arch, {"thickness_ratio": 0.2}, {"radius": 0.1})
    with pytest.raises(InputError, match="above zero"):
        FamilyMoves.of(arch, {"thickness_ratio": 0.2}, {"thickness_ratio": 0.0})


def test_what_stands_already_is_told_and_what_falls_is_not_made_lighter() -> None:
    model = stack(1)
    moves = block_moves(model, ["brick-1"], (1.0, 0.0, 0.0), 0.1)
    assert "stands already" in shape(model, moves).message
    falls = Model.of(arch(0.08, 8), friction=0.8)
    thin = thickening(falls, (0.0, 0.0, 0.0), 0.01)
    said = shape(falls, thin).message
    assert "1 move of 1 as large as allowed: larger ones may help: --most above 0.01" in said
    with pytest.raises(InputError, match="does not stand as it is"):
        shape(falls, thin, options=ShapeOptions(aim="volume"))


def test_it_ends_with_the_best_so_far() -> None:
    model = Model.of(arch(0.2, 8), friction=0.8)
    asked: list[int] = []

    def stop() -> bool:
        asked.append(1)
        return len(asked) > 12

    moves = thickening(model, (0.0, 0.0, 0.0), 0.15)
    found = shape(model, moves, options=ShapeOptions(aim="volume"), stop=stop)
    assert found.stands
    assert "stopped" in found.message


def test_moves_that_make_no_sense_are_refused() -> None:
    model = stack(2)
    every = list(model.assembly.names)
    with pytest.raises(InputError, match="may move: the blocks brick-0, brick-1, brick-2 stay"):
        free_vertices(model, 0.1, keep=every)
    with pytest.raises(InputError, match="the blocks brick-0, brick-1, brick-2 stay"):
        free_vertices(model, 0.1, keep="brick-*")
    with pytest.raises(InputError, match="is no prism along y"):
        free_vertices(Model.of(dome(slices=4, rings=2), friction=0.5), 0.1)
    with pytest.raises(InputError, match="not its own image in another sector"):
        free_vertices(model, 0.1, along=None, sectors=3)
    with pytest.raises(InputError, match="sectors is 0"):
        free_vertices(model, 0.1, sectors=0)
    with pytest.raises(InputError, match="one of 'intrados', 'extrados'"):
        free_vertices(model, 0.1, keep_side="top")
    with pytest.raises(InputError, match="no joint has ends"):
        joint_moves(staggered(), 0.1)
    with pytest.raises(InputError, match="no axis 'w'"):
        free_vertices(model, 0.1, directions="w")
    with pytest.raises(InputError, match="cannot move along y"):
        free_vertices(model, 0.1, directions="y")
    with pytest.raises(InputError, match="most is 0"):
        free_vertices(model, 0.0)
    with pytest.raises(InputError, match="make the moves of this model"):
        shape(stack(1), block_moves(model, ["brick-1"], (1.0, 0.0, 0.0), 0.1))
    with pytest.raises(InputError, match="trust"):
        ShapeOptions(trust=0.0)


def test_the_command_writes_a_shape_that_stands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base, out = tmp_path / "in.json", tmp_path / "out.json"
    drystone.write(Model.of(arch(0.095, 8), friction=0.8), base)
    code = main(["shape", str(base), "--most", "0.05", "--out", str(out), "--json"])
    told = json.loads(capsys.readouterr().out)
    assert code == 0
    assert told["stands"]
    assert drystone.check(drystone.read(out)).stable


def test_an_edge_that_would_have_no_length_left_does_not_end_the_search() -> None:
    """To lose weight far out, the tip gets thin first; the arm has to get shorter too."""
    section = [(0.0, 0.0), (0.5, 0.0), (1.6, 0.2), (1.6, 0.21), (0.0, 0.25)]
    blocks = box((0.5, 0.3, 0.4), (0.0, 0.0, -0.4), "support"), prism(section, (0.0, 0.3), "arm")
    model = Model.of(Assembly(blocks).with_fixed([0]), friction=0.7)
    assert not drystone.check(model).stable
    found = shape(model, free_vertices(model, 0.3))
    assert found.stands
    assert found.value < 1e-3 * found.first
