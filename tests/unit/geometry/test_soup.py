import numpy as np
import pytest

from drystone import Assembly, Block
from drystone.base.arrays import Floats
from drystone.geometry.coincidence import weld
from drystone.geometry.polyhedron import Loop
from drystone.geometry.soup import split_solids, without_slivers
from drystone.geometry.triangulate import triangulate
from drystone.models import arch, barrel_vault, box, concave, dome, tower, wall


def shuffled(assembly: Assembly, rng: np.random.Generator) -> tuple[Floats, list[Loop], list[int]]:
    """All blocks as shuffled triangles over merged vertices, and the block of each triangle."""
    faces = assembly.faces
    triangle, polygon = triangulate(faces.point[faces.loop], faces.start)
    order = rng.permutation(len(triangle))
    loops = [tuple(t) for t in faces.loop[triangle[order]].tolist()]
    welded, _ = weld(faces.point, loops, 1e-9)
    assert len(welded) == len(loops)
    return faces.point, list(welded), faces.owner[polygon[order]].tolist()


@pytest.mark.parametrize(
    "assembly",
    [tower(4), arch(), dome(), concave("short"), wall(), barrel_vault(staggered=False)],
    ids=["tower", "arch", "dome", "concave", "wall", "vault"],
)
def test_touching_blocks_are_told_apart(assembly: Assembly) -> None:
    points, loops, _ = shuffled(assembly, np.random.default_rng(3))
    kept, number = without_slivers(points, loops, np.full(len(points), 1e-9))
    assert len(number) == len(kept)
    solids = split_solids(points, kept)
    assert len(solids) == len(assembly)
    volumes = []
    for solid in solids:
        block = Block(points, tuple(kept[i] for i in solid))
        volumes.append(float(block.volume))
    assert sorted(volumes) == pytest.approx(sorted(assembly.volume))


@pytest.mark.parametrize("turned", [0.0, 1e-9, 0.3, 1.0, 3.141592653589793])
def test_four_cubes_around_an_edge_are_told_apart_however_they_lie(turned: float) -> None:
    c, s = np.cos(turned), np.sin(turned)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    places = [(0, 0, 0), (-1, 0, 0), (-1, -1, 0), (0, -1, 0)]
    blocks = [box((1, 1, 1), at, name=str(i)) for i, at in enumerate(places)]
    assembly = Assembly(tuple(blocks)).transformed(rotation, (1e3, 0.0, 0.0))
    points, loops, block = shuffled(assembly, np.random.default_rng(0))
    solids = split_solids(points, loops)
    assert len(solids) == 4
    assert all(len({block[i] for i in solid}) == 1 for solid in solids)


def test_a_cavity_belongs_to_the_solid_around_it() -> None:
    outer, inner = box((4, 4, 4)), box((1, 1, 1), (1.0, 1.0, 1.0))
    apart = box((1, 1, 1), (9.0, 0.0, 0.0))
    points = np.concatenate([outer.vertices, inner.vertices, apart.vertices])
    loops = [
        *outer.faces,
        *[tuple(i + 8 for i in f)[::-1] for f in inner.faces],
        *[tuple(i + 16 for i in f) for f in apart.faces],
    ]
    assert split_solids(points, loops) == [list(range(12)), list(range(12, 18))]


def test_a_solid_inside_out_next_to_others_is_no_cavity() -> None:
    one, other = box((2, 2, 2)), box((1, 1, 1), (3.0, 0.0, 0.0))
    points = np.concatenate([one.vertices, other.vertices])
    loops = [*one.faces, *[tuple(i + 8 for i in f)[::-1] for f in other.faces]]
    assert split_solids(points, loops) == [list(range(6)), list(range(6, 12))]


def test_a_soup_that_is_inside_out_as_a_whole_is_told_apart_as_well() -> None:
    points, loops, block = shuffled(tower(3), np.random.default_rng(1))
    solids = split_solids(points, [loop[::-1] for loop in loops])
    assert len(solids) == 3
    assert all(len({block[i] for i in solid}) == 1 for solid in solids)


def test_slivers_go_and_their_vertices_stay_on_the_edges_of_their_neighbours() -> None:
    points = np.array([[0.0, 0, 0], [3, 0, 0], [0, 3, 0], [1, 0, 0], [2, 1e-12, 0], [0, -1, 0]])
    loops = [(0, 1, 2), (1, 0, 3), (1, 3, 4), (3, 0, 5), (4, 3, 5), (1, 4, 5)]
    kept, number = without_slivers(points, loops, np.full(len(points), 1e-9))
    assert number.tolist() == [0, 3, 4, 5]
    assert kept == [(0, 3, 4, 1, 2), (3, 0, 5), (4, 3, 5), (1, 4, 5)]


def test_soups_are_split_apart_each_for_itself() -> None:
    """Two soups of two cubes in one place, one of them inside out."""
    points, loops, soup = [], [], []
    for number, (assembly, turned) in enumerate(((tower(2), False), (tower(2), True))):
        vertices, faces, _ = packed(assembly)
        first = sum(map(len, points))
        points.append(vertices)
        loops += [tuple(first + i for i in (f[::-1] if turned else f)) for f in faces]
        soup += [number] * len(faces)
    solids = split_solids(np.concatenate(points), loops, np.array(soup))
    assert [len(solid) for solid in solids] == [6, 6, 6, 6]
    assert all(len({soup[i] for i in solid}) == 1 for solid in solids)


def packed(assembly: Assembly) -> tuple[Floats, list[Loop], list[int]]:
    """All faces of an assembly over merged vertices, and the block of each."""
    faces = assembly.faces
    loops = [
        tuple(faces.loop[a:b].tolist())
        for a, b in zip(faces.start[:-1], faces.start[1:], strict=True)
    ]
    return faces.point, list(weld(faces.point, loops, 1e-9)[0]), faces.owner.tolist()


def test_nothing_makes_no_solid() -> None:
    assert split_solids(np.zeros((0, 3)), []) == []


def test_loose_faces_are_solids_of_their_own() -> None:
    vertices = np.random.default_rng(0).random((300, 3))
    loose: list[Loop] = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(100)]
    assert len(split_solids(vertices, loose)) == 100
