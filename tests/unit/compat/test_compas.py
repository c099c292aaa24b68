import numpy as np
import pytest

from drystone import InputError, MissingDependency, find_contacts
from drystone.compat import compas, from_compas, to_compas
from drystone.models import arch, box, tower
from tests.unit.compat.stand_ins import (
    BlockModel,
    CRAAssembly,
    Element,
    Frame,
    Interface,
    Mesh,
)


def test_an_assembly_becomes_a_model_with_its_contacts() -> None:
    assembly = arch()
    contacts = find_contacts(assembly).contacts
    model = from_compas(CRAAssembly(assembly, contacts), friction=0.7)
    assert model.assembly.names == tuple(str(i) for i in range(len(assembly)))
    assert np.array_equal(model.assembly.fixed, assembly.fixed)
    for one, other in zip(assembly.blocks, model.assembly.blocks, strict=True):
        assert np.array_equal(one.vertices, other.vertices)
        assert one.faces == other.faces
    assert model.contacts is not None
    assert np.array_equal(model.contacts.block_a, contacts.block_a)
    assert model.contacts.frame == pytest.approx(contacts.frame)
    assert model.contacts.area == pytest.approx(contacts.area)
    assert np.array_equal(model.contacts.point, contacts.point)
    assert set(model.contacts.friction.tolist()) == {0.7}


def test_a_block_model_becomes_a_model() -> None:
    lower, upper = tower(2).blocks
    source = BlockModel(
        Element(Mesh(lower), "base", is_support=True),
        Element(Mesh(upper), "stone", density=1800.0),
        Element(Mesh(box((1, 1, 1), (5, 0, 0))), "stone"),
        Element(None, "group"),
    )
    square = [[0.0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]]
    source.graph.edge[0, 1] = {
        "contacts": [Interface(square, Frame([0, 0, 1], [1, 0, 0], [0, 1, 0]))]
    }
    model = from_compas(source)
    assert model.assembly.names == ("base", "stone-1", "stone-2")
    assert model.assembly.fixed.tolist() == [True, False, False]
    assert [b.density for b in model.assembly.blocks] == [2400.0, 1800.0, 2400.0]
    assert model.contacts is not None
    assert model.contacts.area.tolist() == [1.0]
    assert model.contacts.point[0].tolist() == [1.0, 0.0, 1.0]  # counter-clockwise about z


def test_without_contacts_there_are_none() -> None:
    assert from_compas(CRAAssembly(tower(2))).contacts is None


def test_the_source_is_not_changed() -> None:
    source = CRAAssembly(tower(2), find_contacts(tower(2)).contacts)
    before = [list(map(list, i.points)) for i in source.interfaces()]
    from_compas(source)
    assert [list(map(list, i.points)) for i in source.interfaces()] == before
    assert all(i.forces is None for i in source.interfaces())


def test_loose_faces_are_mended_and_that_is_kept() -> None:
    cube = box((1.0, 1.0, 1.0))
    loose = cube.vertices[[i for face in cube.faces for i in face]]
    mesh = Mesh(cube)
    mesh._data = (loose.tolist(), [list(range(4 * i, 4 * i + 4)) for i in range(6)])
    block = compas.block_of(mesh, "a")
    assert len(block.vertices) == 8
    assert block.repairs


@pytest.mark.parametrize("thing", [42, "model", tower(2)])
def test_other_things_are_refused(thing: object) -> None:
    with pytest.raises(InputError, match="neither an assembly nor a model of COMPAS"):
        from_compas(thing)


def test_without_compas_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr("importlib.import_module", missing)
    with pytest.raises(MissingDependency, match=r"\.\[compas\]"):
        to_compas(tower(2))
