import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from drystone import Assembly, Verdict, find_contacts
from drystone.base.errors import MissingDependency
from drystone.compat import compas_cra, from_compas
from drystone.models import box, h_model, tower, wedge
from tests.unit.compat.stand_ins import CRAAssembly, Frame, Interface


@pytest.fixture(autouse=True)
def _frames(monkeypatch: pytest.MonkeyPatch) -> None:
    """COMPAS's geometry, of which the Frame is used."""
    module = ModuleType("compas.geometry")
    module.Frame = Frame  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "compas", ModuleType("compas"))
    monkeypatch.setitem(sys.modules, "compas.geometry", module)


def with_interfaces(assembly: Assembly) -> CRAAssembly:
    source = CRAAssembly(assembly)
    assert compas_cra.assembly_interfaces_numpy(source, nmax=10, tmax=1e-2, amin=1e-3) is source
    return source


def force_on_second(interface: Interface) -> np.ndarray:
    """Sum of the corner forces of an interface on the second block of its edge, world axes."""
    x, y = np.array(interface.frame.xaxis), np.array(interface.frame.yaxis)
    axes = np.stack([np.cross(x, y), x, y])
    assert interface.forces is not None
    assert len(interface.forces) == len(interface.points)
    local = [[f["c_np"] - f["c_nn"], f["c_u"], f["c_v"]] for f in interface.forces]
    return np.asarray(np.array(local).sum(axis=0) @ axes)


def test_interfaces_are_those_of_the_contact_search() -> None:
    assembly = wedge("a")
    source = with_interfaces(assembly)
    contacts = find_contacts(assembly).contacts
    free = ~(assembly.fixed[contacts.block_a] & assembly.fixed[contacts.block_b])
    assert len(source.interfaces()) == int(free.sum())
    assert sum(i.size for i in source.interfaces()) == pytest.approx(contacts.area[free].sum())


def test_small_interfaces_and_those_between_supports_are_left_out() -> None:
    source = CRAAssembly(tower(2))
    compas_cra.assembly_interfaces_numpy(source, amin=2.0)
    assert source.interfaces() == []
    fixed = Assembly(tower(2).blocks, np.array([True, True]))
    assert with_interfaces(fixed).interfaces() == []


def test_a_second_search_adds_nothing() -> None:
    source = with_interfaces(tower(3))
    compas_cra.assembly_interfaces_numpy(source, amin=1e-3)
    assert len(source.interfaces()) == 2


@pytest.mark.parametrize("solve", ["rbe_solve", "cra_solve", "cra_penalty_solve"])
def test_forces_balance_the_weight_with_gravity_one(solve: str) -> None:
    source = with_interfaces(tower(3))
    assert (
        getattr(compas_cra, solve)(source, mu=0.7, density=2.0, verbose=True, timer=True) is source
    )
    lower, upper = (force_on_second(i) for i in source.interfaces())
    assert lower == pytest.approx([0.0, 0.0, 4.0], abs=1e-7)
    assert upper == pytest.approx([0.0, 0.0, 2.0], abs=1e-7)
    assert all(f["c_nn"] == 0.0 for i in source.interfaces() for f in i.forces or [])


def test_densities_of_single_blocks_are_used() -> None:
    source = with_interfaces(tower(3))
    compas_cra.density_setup(source, {2: 5.0})
    compas_cra.rbe_solve(source)
    assert force_on_second(source.interfaces()[0])[2] == pytest.approx(6.0)


def test_corners_that_run_the_other_way_keep_their_order() -> None:
    source = with_interfaces(tower(2))
    (interface,) = source.interfaces()
    order = [list(point) for point in interface.points][::-1]
    interface.points = order
    source.graph.node[1]["block"] = CRAAssembly(
        Assembly((box((1.0, 1.0, 1.0), (0.25, 0.0, 1.0)),))
    ).node_block(0)
    interface.points = [[max(x, 0.25), y, z] for x, y, z in order]
    compas_cra.cra_solve(source)
    assert [list(point) for point in interface.points] == [
        [max(x, 0.25), y, z] for x, y, z in order
    ]
    push = [f["c_np"] for f in interface.forces or []]
    moment = sum(f * x for f, (x, _, _) in zip(push, interface.points, strict=True))
    assert sum(push) == pytest.approx(1.0)
    assert moment == pytest.approx(0.75)


def test_displacements_of_free_blocks_are_such_that_pressed_corners_overlap_by_eps() -> None:
    source = with_interfaces(tower(2))
    compas_cra.cra_solve(source, d_bnd=1e-1, eps=1e-3)
    moved = source.graph.node_attribute(1, "displacement")
    assert moved == pytest.approx([0.0, 0.0, -1e-3, 0.0, 0.0, 0.0], abs=1e-8)
    assert source.graph.node_attribute(0, "displacement") is None


def test_without_an_overlap_the_largest_displacement_is_the_bound() -> None:
    source = with_interfaces(tower(2))
    compas_cra.cra_solve(source, d_bnd=1e-2, eps=0.0)
    moved = source.graph.node_attribute(1, "displacement")
    assert moved == pytest.approx([0.0, 0.0, -1e-2, 0.0, 0.0, 0.0], abs=1e-8)


def test_what_does_not_stand_raises_a_value_error_and_writes_nothing() -> None:
    source = with_interfaces(h_model())
    with pytest.raises(ValueError, match="solve failed: unstable"):
        compas_cra.cra_solve(source)
    assert all(i.forces is None for i in source.interfaces())


def test_rbe_believes_in_prestress() -> None:
    source = with_interfaces(h_model())
    compas_cra.rbe_solve(source)
    assert sum(f["c_nn"] for i in source.interfaces() for f in i.forces or []) < 1e-6


def test_the_penalty_form_answers_with_tension() -> None:
    cubes = (box((1.0, 1.0, 1.0), name="a"), box((1.0, 1.0, 1.0), (0.75, 0.0, 1.0), name="b"))
    source = with_interfaces(Assembly(cubes, np.array([True, False])))
    compas_cra.cra_penalty_solve(source, mu=0.9, d_bnd=1e-1, eps=1e-3)
    (interface,) = source.interfaces()
    assert sum(f["c_nn"] for f in interface.forces or []) > 0.1
    assert force_on_second(interface) == pytest.approx([0.0, 0.0, 1.0], abs=1e-4)


def test_nothing_to_solve_raises_a_value_error() -> None:
    with pytest.raises(ValueError, match="no contact interfaces"):
        compas_cra.rbe_solve(CRAAssembly(tower(2)))


@pytest.mark.parametrize("solve", ["rbe_solve", "cra_solve"])
def test_forces_of_a_solved_assembly_are_read_back(solve: str) -> None:
    source = with_interfaces(tower(3))
    assert from_compas(source).results == ()
    getattr(compas_cra, solve)(source, density=2.0)
    (result,) = from_compas(source).results
    assert result.verdict is Verdict.EQUILIBRIUM_EXISTS
    assert result.resultants.normal == pytest.approx([4.0, 2.0])
    assert (result.displacement is None) == (solve == "rbe_solve")
    assert result.residuals is not None
    assert result.residuals.equilibrium < 1e-6


def test_tension_of_a_solved_assembly_is_read_back() -> None:
    cubes = (box((1.0, 1.0, 1.0), name="a"), box((1.0, 1.0, 1.0), (0.75, 0.0, 1.0), name="b"))
    source = with_interfaces(Assembly(cubes, np.array([True, False])))
    compas_cra.rbe_solve(source, mu=0.9)
    (result,) = from_compas(source).results
    assert result.verdict is Verdict.UNDECIDED
    assert result.tension is not None
    assert result.tension.sum() == pytest.approx(1.0, rel=1e-3)


def test_the_viewer_opens_a_page_with_the_forces_that_are_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: bool(opened.append(url)) or True)
    source = with_interfaces(tower(2))
    compas_cra.cra_view(source)
    compas_cra.cra_solve(source)
    compas_cra.cra_view(source, resultant=False, nodal=True, grid=True)
    compas_cra.cra_view(source, nodal=False, displacements=False)
    keys = []
    for url in opened:
        page = Path(url.removeprefix("file://")).read_text("utf-8")
        keys.append({key for key in ("pressure", "resultants") if f'"key":"{key}"' in page})
    assert keys == [set(), {"pressure"}, {"resultants"}]
    for url in opened:
        Path(url.removeprefix("file://")).unlink()


def test_the_class_of_assemblies_needs_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    compas_cra.assembly_class.cache_clear()
    monkeypatch.setitem(sys.modules, "compas_assembly", None)
    monkeypatch.setitem(sys.modules, "compas_assembly.datastructures", None)
    with pytest.raises(MissingDependency, match="compas_assembly"):
        compas_cra.CRA_Assembly  # noqa: B018
    with pytest.raises(AttributeError, match="no attribute 'cra_wiew'"):
        compas_cra.cra_wiew  # type: ignore[attr-defined]  # noqa: B018
