"""Meshes of other packages are blocks, by their attributes."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from drystone import InputError, MissingDependency, Model, check
from drystone.mesh_objects import assembly_of
from drystone.models import box, concave

BELOW, ABOVE = box((1.0, 1.0, 1.0)), box((1.0, 1.0, 1.0), (0.3, 0.0, 1.0))


class CompasMesh:
    """What a mesh of COMPAS offers."""

    def __init__(self, block, name):
        self.block, self.name = block, name

    def to_vertices_and_faces(self):
        return self.block.vertices.tolist(), [list(face) for face in self.block.faces]


def padded(block):
    """What a PolyData of pyvista offers, its faces in triangles that share no corners."""
    loops = [f for face in block.faces for f in ((face[0], face[1], face[2]),
             (face[0], face[2], face[3]))]  # fmt: skip
    points = block.vertices[[i for loop in loops for i in loop]]
    faces = np.concatenate([[3, 3 * k, 3 * k + 1, 3 * k + 2] for k in range(len(loops))])
    return SimpleNamespace(points=points, faces=faces, regular_faces=faces)


@pytest.mark.parametrize(
    "meshes",
    [
        [CompasMesh(BELOW, "a"), CompasMesh(ABOVE, "b")],
        (padded(BELOW), padded(ABOVE)),
        [SimpleNamespace(vertices=b.vertices, faces=b.faces) for b in (BELOW, ABOVE)],
    ],
    ids=["compas", "pyvista", "trimesh"],
)
def test_a_list_of_meshes_is_a_model(meshes):
    model = Model.of(meshes, supports="lowest", friction=0.6)
    assert [len(block.faces) for block in model.assembly.blocks] == [6, 6]
    assert model.contacts.count == 1
    assert check(meshes, supports="lowest", friction=0.6).stable


def test_a_scene_of_trimesh_has_its_poses_and_names():
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    cube = trimesh.creation.box((1.0, 1.0, 1.0))
    for name, z in (("low", 0.0), ("high", 1.0)):
        move = trimesh.transformations.translation_matrix((0.0, 0.0, z))
        scene.add_geometry(cube, node_name=name, geom_name="cube", transform=move)
    model = Model.of(scene, supports="lowest")
    assert model.assembly.names == ("low", "high")
    assert model.assembly.centroid[:, 2].tolist() == [0.0, 1.0]
    assert model.contacts.count == 1


def test_blocks_of_pyvista_have_their_keys_as_names():
    pyvista = pytest.importorskip("pyvista")
    blocks = pyvista.MultiBlock({"low": pyvista.Cube(), "high": pyvista.Cube(center=(0, 0, 1))})
    model = Model.of(blocks, supports="lowest")
    assert model.assembly.names == ("low", "high")
    assert model.contacts.count == 1


@pytest.mark.parametrize("given", [[], [1, 2], {"a": 1}, 3.5])
def test_what_is_no_mesh_is_refused(given):
    with pytest.raises(InputError, match=r"holds no mesh|cannot be analysed"):
        assembly_of(given)


def test_an_open_mesh_is_refused_with_its_name():
    mesh = SimpleNamespace(vertices=BELOW.vertices, faces=BELOW.faces[1:])
    with pytest.raises(InputError, match="block 'block-0'"):
        Model.of([mesh])


@pytest.mark.parametrize("package", ["trimesh", "pyvista"])
def test_blocks_go_to_other_packages_and_come_back(package):
    pytest.importorskip(package)
    model = Model.of(concave("short"), friction=0.3)
    meshes = getattr(model, f"to_{package}")()
    again = Model.of(meshes, supports=["slab"], friction=0.3)
    assert again.assembly.names == model.assembly.names
    assert again.assembly.volume == pytest.approx(model.assembly.volume)
    assert again.contacts.count == model.contacts.count


@pytest.mark.parametrize("package", ["trimesh", "pyvista"])
def test_a_package_that_is_missing_is_named(package, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingDependency, match=rf"{package}; pip install '\.\[meshes\]'"):
        getattr(Model.of(concave("short")), f"to_{package}")()
