"""Our coupled analysis beside a general nonlinear solver, where that is installed."""

import pytest

from benchmarks.reference import solve_cra_reference
from drystone import (
    InputError,
    LoadCase,
    MissingDependency,
    Model,
    Verdict,
    find_contacts,
    solve_cra,
)
from drystone.models import arch, stool, wedge

X = (1.0, 0.0, 0.0)
CASES = {
    "stool": (stool(), 0.6, 0.0),
    "small arch": (arch(0.3, voussoirs=5), 0.8, 0.0),
    "wedge a, 55 degrees": (wedge("a"), 0.84, 55.0),
    "wedge a, 62 degrees": (wedge("a"), 0.84, 62.0),
    "wedge d, 40 degrees": (wedge("d"), 0.84, 40.0),
    "wedge d, 46 degrees": (wedge("d"), 0.84, 46.0),
    "thin arch": (arch(0.05, voussoirs=5), 0.8, 0.0),
}


@pytest.mark.parametrize("name", CASES)
def test_whatever_the_reference_finds_our_analysis_finds_too(name):
    pytest.importorskip("casadi")
    model, friction, angle = CASES[name]
    contacts = find_contacts(model, friction=friction).contacts
    load = LoadCase.tilt(model, X, angle)
    reference = solve_cra_reference(Model(model, contacts, load))
    ours = solve_cra(Model(model, contacts, load))
    assert ours.verdict is not Verdict.UNDECIDED
    if reference.verdict is Verdict.STABLE:
        assert ours.verdict is Verdict.STABLE
        assert reference.residuals.largest <= 1e-6


def test_a_large_model_is_refused_with_a_remedy():
    pytest.importorskip("casadi")
    model = arch(0.15, voussoirs=120)
    contacts = find_contacts(model, friction=0.8).contacts
    with pytest.raises(InputError, match="use solve_cra"):
        solve_cra_reference(Model(model, contacts))


def test_without_the_extra_the_error_names_it(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "casadi", None)
    model = stool()
    contacts = find_contacts(model, friction=0.6).contacts
    with pytest.raises(MissingDependency, match=r"\.\[reference\]"):
        solve_cra_reference(Model(model, contacts))
