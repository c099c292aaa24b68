"""The frozen answers are of questions that can still be asked, and differences are told."""

import json

import pytest

from benchmarks.same_answers import asking
from benchmarks.same_answers.__main__ import FROZEN
from benchmarks.same_answers.catalogue import questions
from benchmarks.same_answers.comparing import differences, plain
from drystone import LoadCase, Model, models


def tilted(tilt: float) -> Model:
    wedge = models.wedge("a")
    load = LoadCase.tilt(wedge, (1.0, 0.0, 0.0), tilt)
    return Model.of(wedge, friction=0.84, load=load)


def test_every_frozen_answer_belongs_to_a_question_of_the_catalogue() -> None:
    _, *rows = (json.loads(line) for line in FROZEN.read_text("utf-8").splitlines())
    ours = {row["key"] for row in rows if " file " not in row["key"]}
    assert ours <= set(questions())
    assert not [row["key"] for row in rows if "error" in row["answer"]]


def test_an_answer_does_not_differ_from_itself() -> None:
    for tilt in (40.0, 70.0):
        answer = asking.verdict(tilted(tilt))
        assert not list(differences(json.loads(json.dumps(plain(answer))), answer))


def test_another_verdict_another_motion_and_other_blocks_are_told() -> None:
    stands, falls = asking.verdict(tilted(40.0)), asking.verdict(tilted(70.0))
    told = {what for what, _, _ in differences(plain(stands), falls)}
    assert {"verdict", "word", "falls", "moves", "reaction"} <= told
    block, *direction = falls["moves"]
    turned = plain(falls) | {"moves": [block, *(-one for one in direction)], "falls": "7"}
    assert {what for what, _, _ in differences(turned, falls)} == {"moves", "falls"}


@pytest.mark.parametrize(("now", "same"), [(50.001, True), (50.2, False), (None, False)])
def test_limits_may_differ_by_the_width_of_their_brackets(now: float | None, same: bool) -> None:
    assert same is not bool(list(differences({"stands": 50.0}, {"stands": now})))


def test_another_order_of_the_same_blocks_is_as_good() -> None:
    frozen = {"help": [1, 0, 0], "order": [1, 2, 3]}
    assert not list(differences(frozen, {"help": [1, 0, 0], "order": [3, 1, 2]}))
    assert list(differences(frozen, {"help": [1, 0, 0], "order": [1, 2]}))
    assert list(differences(frozen, {"help": [2, 0, 0], "order": [1, 2, 3]}))
