import numpy as np
import pytest
from scipy.spatial import KDTree

from drystone import FormatError, InputError
from drystone.shells import (
    Edge,
    Layout,
    Shape,
    Side,
    barrel_vault,
    build_shell,
    patch_from_mesh,
    read_surface,
)
from drystone.shells.meshfit import distances


def net(rows=13, columns=13, triangles=False, seed=None):
    """A net on a barrel vault, its inner vertices shaken along it where there is a seed."""
    u, v = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns), indexing="ij")
    if seed is not None:
        rng = np.random.default_rng(seed)
        u[1:-1, 1:-1] += rng.uniform(-0.2, 0.2, (rows - 2, columns - 2)) / rows
        v[1:-1, 1:-1] += rng.uniform(-0.2, 0.2, (rows - 2, columns - 2)) / columns
    points = barrel_vault(6.0, 6.0, 2.0).patches[0].point(u, v).reshape(-1, 3)
    n = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack([n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]], axis=-1).reshape(-1, 4)
    faces = [tuple(q) for q in quads.tolist()]
    if triangles:
        faces = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    return points, faces


def away(patch, points):
    """The largest distance of some points from a patch."""
    u, v = (one.ravel() for one in np.meshgrid(*2 * [np.linspace(0.0, 1.0, 60)]))
    near = KDTree(patch.point(u, v)).query(points)[1]
    return distances(patch, np.column_stack([u[near], v[near], points])).max()


@pytest.mark.parametrize("triangles", [False, True])
def test_a_patch_follows_a_mesh(triangles):
    fit = patch_from_mesh(*net(triangles=triangles))
    assert away(fit.patch, net()[0]) < 1e-3


def test_the_deviation_is_that_of_the_faces_too():
    """Flat faces are the sagitta of their chords off a barrel that goes through their vertices."""
    fit = patch_from_mesh(*net())
    radius = (0.25 * 36.0 + 4.0) / 4.0
    half = np.arcsin(3.0 / radius) / 12.0
    assert fit.deviation_max == pytest.approx(radius * (1.0 - np.cos(half)), rel=0.02)


def test_a_mesh_too_coarse_to_tell_its_surface_is_refused():
    with pytest.raises(
        InputError, match=r"m from the patch fitted to it, more than 5%.*finer mesh"
    ):
        patch_from_mesh(*net(rows=3, columns=2), control=(10, 10))


def test_corners_that_are_none_are_refused():
    points, faces = net(rows=13, columns=13)
    with pytest.raises(InputError, match=r"from the patch fitted to it, .*name its corners"):
        patch_from_mesh(points, faces, corners=[0, 1, 2, 3], control=(4, 4))


def test_a_dent_is_a_deviation():
    points, faces = net()
    dented = points.copy()
    dented[84] += [0.0, 0.0, 0.5]  # the middle one
    fit = patch_from_mesh(dented, faces, control=(5, 5))
    assert 0.2 < fit.deviation_max < 0.5


def test_a_shaken_mesh_gives_nearly_the_same_surface():
    fit = patch_from_mesh(*net(seed=5))
    radius = (0.25 * 36.0 + 4.0) / 4.0
    points = fit.patch.point(*np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9)))
    distance = np.hypot(points[..., 0], points[..., 2] - (2.0 - radius))
    assert np.abs(distance - radius).max() < 0.02


def test_corners_may_be_named():
    points, faces = net()
    fit = patch_from_mesh(points, faces, corners=[12, 168, 156, 0])
    assert np.allclose(fit.patch.point([0, 0, 1, 1], [0, 1, 1, 0]), fit.corners, atol=1e-3)
    assert np.allclose(fit.corners, points[[12, 168, 156, 0]])


def test_corners_may_be_named_either_way_round():
    points, faces = net()
    for corners in ([0, 12, 168, 156], [0, 156, 168, 12]):
        fit = patch_from_mesh(points, faces, corners=corners)
        assert np.allclose(fit.patch.point([0, 0, 1, 1], [0, 1, 1, 0]), points[corners], atol=1e-3)


def test_repeated_vertices_are_one():
    points, faces = net()
    soup = points[[i for face in faces for i in face]]
    loops = [tuple(range(4 * k, 4 * k + 4)) for k in range(len(faces))]
    assert away(patch_from_mesh(soup, loops).patch, points) < 1e-3


def test_a_mesh_file_becomes_a_shell(tmp_path):
    points, faces = net()
    lines = [f"v {x} {y} {z}" for x, y, z in points.tolist()]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    path = tmp_path / "surface.obj"
    path.write_text("\n".join(lines))
    fit = patch_from_mesh(*read_surface(path))
    shape = Shape((fit.patch,), supports=(Edge(0, Side.BOTTOM), Edge(0, Side.TOP)))
    shell = build_shell(shape, Layout(courses=9, blocks=4))
    assert shell.planar.reached
    assert len(shell.voussoirs) == 40


def test_a_closed_mesh_is_refused():
    cube = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
    with pytest.raises(InputError, match="mesh is closed; of a vault with a thickness delete"):
        patch_from_mesh(cube, faces)


def test_a_mesh_with_a_hole_is_refused():
    points, faces = net()
    with pytest.raises(InputError, match="several borders"):
        patch_from_mesh(points, faces[:70] + faces[71:])


def test_a_mesh_that_closes_to_a_ring_is_told_from_turned_faces():
    angle, height = np.meshgrid(np.arange(12) * np.pi / 6.0, [0.0, 0.5, 1.0])
    points = np.stack([np.cos(angle), np.sin(angle), height], axis=-1).reshape(-1, 3)
    faces = [
        (12 * i + j, 12 * i + (j + 1) % 12, 12 * i + 12 + (j + 1) % 12, 12 * i + 12 + j)
        for i in range(2)
        for j in range(12)
    ]
    with pytest.raises(InputError, match=r"closed to a ring.*patch_from_grid with closed=True"):
        patch_from_mesh(points, faces)
    flat, loops = net()
    with pytest.raises(InputError, match="opposite normals"):
        patch_from_mesh(flat, [loops[0][::-1], *loops[1:]])


def test_a_round_mesh_needs_its_corners_named():
    angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    points = np.concatenate([[[0.0, 0.0, 0.4]], rim])
    faces = [(0, 1 + k, 1 + (k + 1) % 48) for k in range(48)]
    with pytest.raises(InputError, match="no four corners"):
        patch_from_mesh(points, faces)


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        ([0, 12, 168, 999], "999 is no vertex of its faces; give different numbers .* 0 to 168"),
        ([0, 12, 12, 156], "12 is named twice"),
        ([0, 12, 168, 84], "number 4 of 4 is not on the border; name vertices of the border"),
        ([0, 168, 12, 156], "do not follow each other; name them in their order along the border"),
        ([0, 12, 168], "a patch has four; name four, or the two ends of each of three or more"),
    ],
)
def test_corners_that_cannot_be_used_are_told_with_what_to_do(corners, words):
    with pytest.raises(InputError, match=words):
        patch_from_mesh(*net(), corners=corners)


def test_a_file_without_faces_is_refused(tmp_path):
    path = tmp_path / "points.obj"
    path.write_text("v 0 0 0\nv 1 0 0\n")
    with pytest.raises(FormatError, match=r"points\.obj"):
        read_surface(path)


def test_a_mesh_of_which_products_overflow_is_refused():
    vertices, faces = net()
    vertices = np.array(vertices)
    vertices[0] = 1e308
    with pytest.raises(InputError, match="give metres"):
        patch_from_mesh(vertices, faces)
