"""Parameters by search: known optima, the same answer with one worker and two, and after an end."""

import json
from functools import partial
from pathlib import Path

import pytest

import drystone
from drystone import Assembly, FormatError, InputError
from drystone.cli import main
from drystone.design import DesignMargin, Parameter, TuneOptions, tune
from drystone.design.tuning import outcome_of, planned_counts
from drystone.models import arch, box, tower
from drystone.sequence import LocalWorkers

pytest.importorskip("optuna")

STACK = partial(tower, 3)
THICKNESS = Parameter("thickness_ratio", 0.05, 0.3)


def leaning(overhang: float) -> Assembly:
    """A box that reaches beyond another one of the same size."""
    below, above = (
        box((1.0, 1.0, 1.0), name="below"),
        box((1.0, 1.0, 1.0), (overhang, 0, 1), "above"),
    )
    return Assembly((below, above)).with_fixed([0])


def test_the_farthest_overhang_of_one_brick_is_half_of_it() -> None:
    options = TuneOptions(trials=48)
    found = tune(leaning, [Parameter("overhang", 0.0, 0.9)], goals=["-overhang"], options=options)
    assert 0.48 < found.front[0].values["overhang"] <= 0.5
    assert all(trial.values["overhang"] <= 0.5 for trial in found.trials if trial.stands)


def test_what_it_finds_stands_and_falls_are_told() -> None:
    found = tune(arch, [THICKNESS], how={"friction": 0.8}, options=TuneOptions(trials=12))
    best = found.front[0]
    assert drystone.check(arch(best.values["thickness_ratio"]), friction=0.8).stable
    assert all(trial.message for trial in found.trials if not trial.stands)


def test_the_front_of_two_goals_has_no_trial_that_another_one_beats() -> None:
    found = tune(
        tower,
        [Parameter("edge", 0.5, 2.0), Parameter("count", 2, 5, whole=True)],
        goals=["volume", "-height"],
        options=TuneOptions(trials=24),
    )
    front = found.front
    assert len(front) > 1
    volumes, heights = ([trial.goals[i] for trial in front] for i in (0, 1))
    assert volumes == sorted(volumes)
    assert heights == sorted(heights)
    assert all(isinstance(trial.values["count"], int) for trial in found.trials)


def test_a_search_that_was_ended_goes_on_to_the_same_answer(tmp_path: Path) -> None:
    edge = Parameter("edge", 0.5, 2.0)
    options = TuneOptions(trials=12, batch=4)
    known: list[int] = []
    store = tmp_path / "search.log"
    part = tune(
        STACK, [edge], store=store, options=options,
        stop=lambda: len(known) > 4, progress=lambda _, done, __: known.append(done),
    )  # fmt: skip
    assert 0 < len(part.trials) < 12
    whole = tune(STACK, [edge], store=store, options=options)
    once = tune(STACK, [edge], options=options)
    assert [one.values for one in whole.trials] == [one.values for one in once.trials]
    with pytest.raises(FormatError, match="cannot be written: No such file or directory"):
        tune(STACK, [edge], store=tmp_path / "nowhere" / "search.log", options=options)
    with pytest.raises(FormatError, match="other work: parameters differ"):
        tune(STACK, [Parameter("edge", 0.5, 3.0)], store=store, options=options)
    with pytest.raises(FormatError, match="other work: structures differ"):
        tune(partial(tower, 2), [edge], store=store, options=options)
    with pytest.raises(FormatError, match="other work: structures differ"):
        tune(STACK, [edge], how={"friction": 0.2}, store=store, options=options)


def test_two_workers_find_the_same_as_none() -> None:
    edge = Parameter("edge", 0.5, 2.0)
    options = TuneOptions(trials=8, batch=4, seed=3)
    together = tune(STACK, [edge], options=options, executor=LocalWorkers(2))
    alone = tune(STACK, [edge], options=options)
    assert [(one.values, one.goals) for one in together.trials] == [
        (one.values, one.goals) for one in alone.trials
    ]
    assert all(one.stands for one in together.trials)


def test_the_help_that_a_shell_needs_is_a_goal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, png = tmp_path / "shell.json", tmp_path / "front.png"
    words = ["tune", "dome-shell", "--vary", "thickness=0.4:0.6", "--vary", "wedge=0:0.3"]
    words += ["--set", "courses=2", "--set", "blocks=4", "--set", "eye=2"]
    words += ["--least", "props", "--least", "held", "--props", "8", "--trials", "2"]
    code = main([*words, "--friction", "0.7", "--out", str(out), "--png", str(png), "--json"])
    told = json.loads(capsys.readouterr().out)
    assert png.read_bytes().startswith(b"\x89PNG")
    assert code == 0
    model = drystone.read(out)
    assert drystone.check(model).stable
    counts = planned_counts(model)[0]
    assert told["front"][0]["goals"] == [counts["propped"], counts["held"]]


def test_a_structure_that_needs_too_many_props_is_told_as_such() -> None:
    asked = ("props", "held"), DesignMargin(), 0
    goals, good, why = outcome_of(partial(arch, 0.3), {"friction": 0.4}, *asked, {"voussoirs": 5})
    assert not good
    assert goals[0] > 0.0
    assert "need a prop" in why
    assert outcome_of(tower, {}, *asked, {"count": 3}) == ((0.0, 0.0), True, "")


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(InputError, match="are empty"):
        Parameter("edge", 1.0, 1.0)
    with pytest.raises(InputError, match="no goal"):
        tune(tower, [Parameter("edge", 1.0, 2.0)], goals=["weight"])
    with pytest.raises(InputError, match="contradict"):
        tune(tower, [Parameter("edge", 1.0, 2.0)], goals=["volume", "-volume"])
    with pytest.raises(InputError, match="no parameter is varied"):
        tune(tower, [])
    with pytest.raises(InputError, match="trials is 0"):
        TuneOptions(trials=0)
    with pytest.raises(InputError, match="props is -1"):
        TuneOptions(props=-1)


def test_the_command_writes_the_best_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "best.json"
    words = ["tune", "arch", "--vary", "thickness_ratio=0.08:0.3", "--set", "voussoirs=8"]
    code = main([*words, "--friction", "0.8", "--trials", "6", "--out", str(out), "--json"])
    told = json.loads(capsys.readouterr().out)
    assert code == 0
    assert told["front"][0]["stands"]
    assert drystone.check(drystone.read(out)).stable
    assert main(["tune", "arch", "--vary", "width=1:2"]) == 2
    assert main([*words, "--vary", "voussoirs=6:9"]) == 2
    assert "voussoirs is set, and varied" in capsys.readouterr().err
    assert main(["tune", "arch"]) == 2
