"""What a result says of itself."""

import numpy as np
import pytest

import drystone
from drystone import Model, Result, Verdict
from drystone.models import tower

MODEL = Model.of(tower(3))


@pytest.mark.parametrize("verdict", list(Verdict))
def test_it_is_stable_or_falls_where_that_was_shown(verdict: Verdict) -> None:
    result = Result("check", verdict, MODEL)
    assert result.stable is (verdict is Verdict.STABLE)
    assert result.falls is (verdict is Verdict.UNSTABLE)


def test_it_is_neither_true_nor_false() -> None:
    with pytest.raises(TypeError, match=r"ask for \.stable"):
        assert Result("check", Verdict.STABLE, MODEL)


def test_resultants_are_found_once_and_cannot_be_changed() -> None:
    result = drystone.check(MODEL)
    assert result.resultants is result.resultants
    assert result.utilisation is result.utilisation
    with pytest.raises(ValueError, match="read-only"):
        result.resultants.normal[0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        result.utilisation[0] = 0.0


def test_the_graph_has_blocks_in_its_nodes_and_forces_in_its_edges() -> None:
    pytest.importorskip("networkx")
    result = drystone.check(MODEL)
    graph = result.graph()
    assert [graph.nodes[i]["fixed"] for i in graph] == [True, False, False]
    assert graph.nodes[1]["block"] is MODEL.assembly.blocks[1]
    for _, above, edge in graph.edges(data=True):
        weight = -sum(graph.nodes[i]["load"] for i in graph if i >= above)
        assert edge["resultant"] == pytest.approx(weight[:3], abs=1e-6)
        assert np.shape(edge["force"]) == np.shape(edge["points"]) == (4, 3)
        assert (edge["force"] @ edge["frame"]).sum(axis=0) == pytest.approx(edge["resultant"])
        assert edge["centre"] == pytest.approx(edge["points"].mean(axis=0))
        assert edge["friction"] == 0.6
        assert "tension" not in edge
    pulled = drystone.solve_rbe(drystone.models.overhang([0.6]), friction=0.8).graph()
    assert [edge["tension"].sum() > 0.0 for *_, edge in pulled.edges(data=True)] == [True]
    assert "force" not in MODEL.graph().edges[0, 1, 0]
