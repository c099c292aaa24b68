import json
import math
import sys
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import measure, speed
from benchmarks.machine import ask
from benchmarks.workloads import DOMES, VAULTS, WALLS, workloads
from drystone import Verdict

WORK = workloads()
OURS = {"right": True, "defect": "", "one_thread": True, "total_s": 0.5, "verdict": "stable"}


def row(ours=None, peer=None, key="type-a"):
    return speed.Row(WORK[key], OURS | (ours or {}), peer or {})


@pytest.mark.parametrize("name", ["wall-400", "dome-160", "vault-97"])
def test_models_have_about_as_many_blocks_as_their_name_says(name):
    count = {"wall": WALLS, "dome": DOMES, "vault": VAULTS}
    family, number = name.split("-")
    assert int(number) in count[family]
    assert len(WORK[name].build()) == pytest.approx(int(number), rel=0.1)


@pytest.mark.parametrize("key", ["type-d@41", "type-d@41.6"])
def test_either_side_of_a_limit_is_answered_with_its_proof(key):
    found = measure.measure(WORK[key], whole=False, enough_s=0.0)
    assert (found["right"], found["defect"]) == (True, "")
    assert found["total_s"] > 0.0


def test_an_answer_without_its_proof_is_found_out():
    work = WORK["arch"]
    assembly = work.build()
    contacts = work.find(assembly)
    result = measure._question(work, assembly, contacts, work.load(assembly))()
    assert measure.defect(result) == ""
    assert measure.defect(replace(result, displacement=None)) == "no forces"
    balanced = replace(result, verdict=Verdict.EQUILIBRIUM_EXISTS)
    assert measure.defect(balanced) == ""
    assert "unbalanced" in measure.defect(replace(balanced, force=1.001 * result.force))
    falls = replace(result, verdict=Verdict.UNSTABLE)
    assert measure.defect(falls) == "no mechanism"
    sinks = np.zeros((len(assembly), 6))
    sinks[~assembly.fixed, 2] = -1.0
    assert "closes" in measure.defect(replace(falls, mechanism=sinks))


@pytest.mark.parametrize(
    "ours", [{"right": False}, {"defect": "residual 1e-3"}, {"one_thread": False}, {"failed": "x"}]
)
def test_a_wrong_answer_has_no_time_and_no_ratio(ours):
    wrong = row(ours, {"solve_s": 5.0})
    assert math.isnan(wrong.seconds)
    assert math.isnan(wrong.ratio())
    assert "WRONG" in speed.table([wrong])[-1]


def test_the_ratio_is_the_time_of_the_peer_by_ours():
    assert row(peer={"solve_s": 5.0, "answer": "solved"}).ratio() == 10.0
    assert math.isnan(row().ratio())
    stopped = row(peer={"solve_s": 60.0, "answer": "none after 60 s", "stopped": True})
    assert ">120" in speed.table([stopped])[-1]


def test_the_faster_convex_solver_is_compared_and_one_that_agrees_is_enough():
    said = {"rbe": "equilibrium exists", "piqp": "solved", "clarabel": "failed"}
    one = replace(row(), convex=said | {"rbe_s": 0.25, "piqp_s": 1.0, "clarabel_s": 2.0})
    assert (one.convex_ratio(0.25), one.convex_ratio()) == (4.0, 2.0)
    assert not one.differs
    assert replace(one, convex=one.convex | {"piqp": "primal_infeasible"}).differs
    assert (math.isnan(row().convex_ratio()), row().differs) == (True, False)


def test_convex_solvers_are_asked_what_our_rbe_is_asked():
    pytest.importorskip("piqp")
    for key, ours, theirs in (
        ("type-d@41", "equilibrium exists", {"solved"}),
        ("type-d@41.6", "unstable", {"primal_infeasible", "infeasible"}),
    ):
        found = measure.convex(WORK[key], enough_s=0.0)
        assert found["rbe"] == ours
        assert {found["piqp"], found["clarabel"]} <= theirs
        assert min(found[f"{name}_s"] for name in ("rbe", *speed.CONVEX)) > 0.0


def test_each_phase_is_compared_with_the_commit_before():
    before = {"right": True, "total_s": 0.25, "detect_s": 0.1}
    pair = replace(row({"detect_s": 0.11}), before=before)
    assert (pair.slower(), pair.slower("detect_s")) == pytest.approx((2.0, 1.1))
    assert math.isnan(pair.slower("whole_s"))
    assert math.isnan(row().slower())
    assert math.isnan(replace(pair, before=before | {"right": False}).slower())


def test_a_commit_is_asked_by_its_own_package_and_benchmark(tmp_path):
    words = "import json, os; print(json.dumps([os.getcwd(), os.environ['PYTHONPATH']]))"
    there = ask([sys.executable, "-c", words], 5.0, tmp_path)
    assert there == [str(tmp_path), str(tmp_path / "src")]


def test_growth_is_the_exponent_of_a_power_law():
    sizes = (400, 2_000, 10_000)
    assert speed.slope([(n, 3e-4 * n**1.25) for n in sizes]) == pytest.approx(1.25)
    assert math.isnan(speed.slope([(400, math.nan), (2_000, 1.0)]))


def test_every_row_of_a_table_has_the_columns_of_its_head():
    lines = speed.table([row(), row({"failed": "none after 1 s"}), row(peer={"answer": "solved"})])
    assert len({line.count("|") for line in lines}) == 1


def test_a_process_is_stopped_after_its_share_of_time():
    endless = ask([sys.executable, "-c", "while True: pass"], 1.0)
    assert endless == {"failed": "none after 1 s", "stopped": True}
    assert ask([sys.executable, "-c", "1 / 0"], 5.0)["failed"].startswith("ZeroDivisionError")


def test_a_measured_process_has_one_thread():
    words = "import os, json; print(json.dumps(dict(os.environ)))"
    assert ask([sys.executable, "-c", words], 5.0)["OPENBLAS_NUM_THREADS"] == "1"


def test_the_peer_is_given_the_model_turned_and_its_joints(tmp_path):
    work = WORK["type-d@41"]
    assembly = work.build()
    measure.dump(work, tmp_path / "model.json")
    model = json.loads((tmp_path / "model.json").read_text())
    assert len(model["blocks"]) == len(assembly)
    assert model["fixed"] == np.flatnonzero(assembly.fixed).tolist()
    one = model["interfaces"][0]
    normal = np.array(one["frame"][0])
    points = np.array(one["points"])
    np.testing.assert_allclose((points - points[0]) @ normal, 0.0, atol=1e-12)
    turned = np.array(model["blocks"][0]["vertices"])
    assert not np.allclose(turned, assembly.blocks[0].vertices)
    assert np.linalg.norm(turned, axis=1) == pytest.approx(
        np.linalg.norm(assembly.blocks[0].vertices, axis=1)
    )


def test_the_limit_of_the_arch_is_measured():
    assert measure.measure(WORK["arch-tilt-limit"], whole=False, enough_s=0.0)["right"]
