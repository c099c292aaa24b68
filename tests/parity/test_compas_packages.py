"""Converters against the installed packages of COMPAS; skipped where they are not.

``pip install ".[compas,test]"`` for compas_dem and compas_model; ``pip install compas_cra``
for the last ones.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drystone import Assembly, LoadCase, Model, Result, Verdict, find_contacts, io
from drystone.assembly import replace_block
from drystone.compat import from_compas, to_compas
from drystone.compat.compas import CompasKind
from drystone.models import arch, box, vault


def same_blocks(one: Assembly, other: Assembly) -> None:
    assert one.names == other.names
    assert np.array_equal(one.fixed, other.fixed)
    for a, b in zip(one.blocks, other.blocks, strict=True):
        assert np.array_equal(a.vertices, b.vertices)
        assert (a.faces, a.density) == (b.faces, b.density)


def result_of(assembly: Assembly) -> Result:
    contacts = find_contacts(assembly).contacts
    force = np.arange(3.0 * contacts.corner_count).reshape(-1, 3)
    load = LoadCase.gravity(assembly)
    return Result("rbe", Verdict.UNDECIDED, Model(assembly, contacts, load), force=force)


def dense(assembly: Assembly) -> Assembly:
    blocks = tuple(
        replace_block(block, density=2000.0 + i % 3) for i, block in enumerate(assembly.blocks)
    )
    return Assembly(blocks, assembly.fixed)


@pytest.mark.parametrize(
    ("kind", "package"),
    [(CompasKind.ASSEMBLY, "compas_assembly"), (CompasKind.BLOCK_MODEL, "compas_dem")],
)
@pytest.mark.parametrize("assembly", [arch(), vault()])
def test_there_and_back_keeps_blocks_and_contacts(
    kind: CompasKind, package: str, assembly: Assembly, tmp_path: Path
) -> None:
    pytest.importorskip(package)
    compas = pytest.importorskip("compas")
    result = result_of(dense(assembly))
    obj = to_compas(result, kind)
    model = from_compas(obj)
    same_blocks(result.assembly, model.assembly)
    assert model.contacts is not None
    assert np.array_equal(model.contacts.block_a, result.contacts.block_a)
    assert model.contacts.area == pytest.approx(result.contacts.area)
    compas.json_dump(obj, tmp_path / "model.json")
    read = io.read(tmp_path / "model.json")
    same_blocks(result.assembly, read.assembly)
    assert read.contacts is not None
    assert read.contacts.point == pytest.approx(result.contacts.point)


def test_a_block_model_of_compas_dem_is_read_the_same_from_memory_and_file(tmp_path: Path) -> None:
    pytest.importorskip("compas_dem")
    import compas
    from compas.geometry import Box, Translation
    from compas_dem.elements import Block
    from compas_dem.material import Stone
    from compas_dem.models import BlockModel

    model = BlockModel()
    for i in range(3):
        block = Block.from_box(Box(1, 1, 1), name="stone")
        block.transformation = Translation.from_vector([0.1 * i, 0, 1.0 * i])
        block.is_support = i == 0
        model.add_element(block)
    stone = Stone(density=1900)
    model.add_material(stone)
    model.assign_material(stone, elements=list(model.elements()))
    model.transformation = Translation.from_vector([5, 0, 0])
    model.compute_contacts()
    here = from_compas(model)
    compas.json_dump(model, tmp_path / "model.json")
    there = io.read(tmp_path / "model.json")
    same_blocks(here.assembly, there.assembly)
    assert here.assembly.fixed.tolist() == [True, False, False]
    assert [b.density for b in here.assembly.blocks] == [1900.0] * 3
    assert here.assembly.bounds[2, 0].tolist() == pytest.approx([4.7, -0.5, 1.5])
    assert here.contacts is not None
    assert there.contacts is not None
    found = find_contacts(here.assembly).contacts
    for contacts in (here.contacts, there.contacts):
        assert sorted(contacts.area) == pytest.approx(sorted(found.area))
        assert contacts.frame[:, 0] == pytest.approx(found.frame[:, 0])


def cra_cubes(degrees: float) -> Any:
    pytest.importorskip("compas_cra")
    from compas_assembly.datastructures import Block as CompasBlock
    from compas_cra.datastructures import CRA_Assembly

    assembly = CRA_Assembly()
    for z in (0.0, 1.0):
        cube = box((1.0, 1.0, 1.0), (-0.5, -0.5, z))
        faces = [list(face) for face in cube.faces]
        assembly.add_block(CompasBlock.from_vertices_and_faces(cube.vertices.tolist(), faces))
    assembly.set_boundary_conditions([0])
    assembly.rotate_assembly([0, 0, 0], [0, 1, 0], degrees)
    return assembly


def resultants(assembly: Any) -> np.ndarray:
    """Per interface the force on the second block, world axes."""
    out = []
    for interface in assembly.interfaces():
        x, y = np.array(interface.frame.xaxis), np.array(interface.frame.yaxis)
        local = [[f["c_np"] - f["c_nn"], f["c_u"], f["c_v"]] for f in interface.forces]
        out.append(np.array(local).sum(axis=0) @ np.stack([np.cross(x, y), x, y]))
    return np.array(out)


@pytest.mark.parametrize("solver", ["rbe_solve", "cra_solve", "cra_penalty_solve"])
def test_solvers_give_the_resultants_of_compas_cra(
    solver: str, capsys: pytest.CaptureFixture[str]
) -> None:
    theirs, ours = cra_cubes(20.0), cra_cubes(20.0)
    import compas_cra.algorithms
    import compas_cra.equilibrium

    from drystone.compat import compas_cra as own

    compas_cra.algorithms.assembly_interfaces_numpy(theirs)
    own.assembly_interfaces_numpy(ours)
    assert len(list(ours.interfaces())) == len(list(theirs.interfaces())) == 1
    getattr(compas_cra.equilibrium, solver)(theirs, d_bnd=1e-2) if solver != "rbe_solve" else (
        compas_cra.equilibrium.rbe_solve(theirs)
    )
    getattr(own, solver)(ours)
    assert resultants(ours) == pytest.approx(resultants(theirs), abs=1e-6)


def test_what_slides_raises_value_error_in_both(capsys: pytest.CaptureFixture[str]) -> None:
    theirs, ours = cra_cubes(44.0), cra_cubes(44.0)
    import compas_cra.algorithms
    import compas_cra.equilibrium

    from drystone.compat import compas_cra as own

    compas_cra.algorithms.assembly_interfaces_numpy(theirs)
    own.assembly_interfaces_numpy(ours)
    for solve, assembly in ((compas_cra.equilibrium.cra_solve, theirs), (own.cra_solve, ours)):
        with pytest.raises(ValueError, match="solve failed"):
            solve(assembly, mu=0.84)


def test_the_example_of_section_8_4_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("compas_assembly")
    import compas
    from compas.geometry import Box, Frame, Rotation, Translation
    from compas_assembly.datastructures import Block as CompasBlock

    from drystone.compat.compas_cra import (
        CRA_Assembly,
        assembly_interfaces_numpy,
        cra_solve,
        cra_view,
    )

    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: bool(opened.append(url)) or True)

    def box_of(frame: Any, *sizes: float) -> Any:
        """COMPAS 1 took the frame first."""
        return Box(frame, *sizes) if compas.__version__ < "2" else Box(*sizes, frame=frame)

    turned = Translation.from_vector([0, 0, 1]) * Rotation.from_axis_and_angle([0, 0, 1], 0.2)
    assembly = CRA_Assembly()
    assembly.add_block(CompasBlock.from_shape(box_of(Frame.worldXY(), 4, 2, 1)), node=0)
    plane = Frame.worldXY().transformed(turned)
    assembly.add_block(CompasBlock.from_shape(box_of(plane, 1, 3, 1)), node=1)
    assembly.set_boundary_conditions([0])
    assembly_interfaces_numpy(assembly)
    cra_solve(assembly, verbose=True, timer=True)
    cra_view(assembly, resultant=False, nodal=True, grid=True)
    assert len(opened) == 1
    assert resultants(assembly) == pytest.approx(np.array([[0.0, 0.0, 3.0]]), abs=1e-9)
    compas.json_dump(assembly, tmp_path / "solved.json")
    assert compas.json_load(tmp_path / "solved.json").graph.number_of_nodes() == 2
    for contents in (from_compas(assembly), io.read_file(tmp_path / "solved.json")):
        (result,) = contents.results
        assert result.verdict is Verdict.EQUILIBRIUM_EXISTS
        assert result.resultants.normal == pytest.approx([3.0])


def test_an_assembly_of_compas_cra_is_turned_moved_and_weighed() -> None:
    pytest.importorskip("compas_assembly")
    from compas_assembly.datastructures import Block as CompasBlock

    from drystone.compat.compas_cra import CRA_Assembly, assembly_interfaces_numpy

    assembly = CRA_Assembly()
    for z in (0.0, 1.5):
        cube = box((1.0, 1.0, 1.0), (0.0, 0.0, z))
        faces = [list(face) for face in cube.faces]
        assembly.add_block(CompasBlock.from_vertices_and_faces(cube.vertices.tolist(), faces))
    assembly.move_block(1, (0.0, 0.0, -0.5))
    assembly.set_boundary_condition(0)
    assert [assembly.is_block_support(key) for key in (0, 1)] == [True, False]
    assembly_interfaces_numpy(assembly)
    assembly.rotate_assembly([0, 0, 0], [0, 1, 0], np.pi / 2)
    (interface,) = assembly.interfaces()
    assert [x for x, _, _ in interface.points] == pytest.approx([1.0] * 4)
    assert assembly.get_weight_total(2.0) == pytest.approx(4.0)
    assert assembly.get_weight_mean(2.0) == pytest.approx(2.0)
