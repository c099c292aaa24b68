"""Many models, their verdicts in a file that can be continued."""

import os
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from pathlib import Path

import pytest

import drystone
from benchmarks.workloads import random_pile
from drystone import InputError
from drystone.models import shelf, tower

MODELS = [tower(2), shelf(), tower(3), tower(4)]
VERDICTS = ["stable", "unstable", "stable", "stable"]


class Deadly:
    """Ends the process that it is unpacked in."""

    def __reduce__(self) -> tuple[object, tuple[int]]:
        return os._exit, (1,)


def test_answers_do_not_depend_on_who_works() -> None:
    alone = drystone.check_many(MODELS, friction=0.6)
    assert alone["verdict"].tolist() == VERDICTS
    with ThreadPoolExecutor(2) as threads:
        shared = drystone.check_many(iter(MODELS), friction=0.6, executor=threads)
    for name in ("number", "verdict", "falling", "message", "stiffnesses_standing"):
        assert shared[name].tolist() == alone[name].tolist()


def test_a_model_has_the_answer_of_a_check_whatever_models_are_beside_it() -> None:
    piles = [random_pile(seed) for seed in (0, 1, 2, 3, 4, 10, 23)]
    alone = [drystone.check(one) for one in piles]
    for order in ([0, 1, 2, 3, 4, 5, 6], [6, 3, 0, 5]):
        told = drystone.check_many([piles[number] for number in order])
        for row, number in enumerate(order):
            one = alone[number]
            assert told["verdict"][row] == one.verdict.value
            assert told["message"][row] == one.message
            assert told["falling"][row] == " ".join(one.falling_names)
            assert told["stiffnesses_standing"][row] == one.samples.standing


def test_work_that_was_ended_goes_on_where_its_file_ends(tmp_path: Path) -> None:
    out = tmp_path / "found.jsonl"
    asked = iter([False, False, True])
    first = drystone.check_many(MODELS, out=out, friction=0.6, stop=lambda: next(asked, True))
    assert len(first) == 2
    with out.open("a", encoding="utf-8") as file:
        file.write('00ab12cd [2,"","sta')  # killed while it wrote
    told: list[tuple[int, int]] = []

    def progress(_: str, done: int, total: int) -> None:
        told.append((done, total))

    whole = drystone.check_many(MODELS, out=out, friction=0.6, progress=progress)
    assert told == [(3, 4), (4, 4)]
    assert whole["verdict"].tolist() == VERDICTS
    assert len(out.read_text(encoding="utf-8").splitlines()) == 5
    again = drystone.check_many(MODELS, out=out, friction=0.6)
    assert again["message"].tolist() == whole["message"].tolist()


def test_a_file_about_other_models_is_not_continued(tmp_path: Path) -> None:
    out, model = tmp_path / "found.jsonl", tmp_path / "tower.json"
    drystone.check_many([tower(2)], out=out)
    drystone.write(tower(2), model)
    with pytest.raises(InputError, match="model 0 of the file is '', not "):
        drystone.check_many([model], out=out)
    for kept, first, other in (("b", model, tower(3)), ("c", tower(2), tower(3))):
        drystone.check_many([first], out=tmp_path / kept)
        if first is model:
            drystone.write(other, model)
        with pytest.raises(InputError, match="has another content than it had"):
            drystone.check_many([model if first is model else other], out=tmp_path / kept)
    out.write_text("a,b\n1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="is no journal"):
        drystone.check_many([tower(2)], out=out)
    with pytest.raises(InputError, match="cannot be written"):
        drystone.check_many([tower(2)], out=tmp_path / "nowhere" / "found.jsonl")


def test_what_is_no_model_is_refused_in_its_row(tmp_path: Path) -> None:
    found = drystone.check_many([tmp_path / "nothing.json", tower(2)])
    assert found["verdict"].tolist() == ["refused", "stable"]
    assert "there is no such file" in found["message"][0]


@pytest.mark.parametrize("one", [tower(2), drystone.Model.of(tower(2)), "tower.json", 3])
def test_one_model_alone_is_refused_and_not_taken_for_its_blocks(one: object) -> None:
    with pytest.raises(InputError, match="give a list of models"):
        drystone.check_many(one)  # type: ignore[arg-type]


def test_a_model_that_ends_its_worker_is_told_and_the_others_are_answered() -> None:
    def models() -> Iterator[object]:
        yield from (tower(2), Deadly(), tower(3))

    start = partial(ProcessPoolExecutor, 1)
    found = drystone.check_many(models(), executor=start)  # type: ignore[arg-type]
    assert found["verdict"].tolist() == ["stable", "failed", "stable"]
    with ProcessPoolExecutor(1) as processes, pytest.raises(InputError, match="a worker died"):
        drystone.check_many(models(), executor=processes)  # type: ignore[arg-type]


def test_a_scheduler_that_dies_is_told_and_the_file_keeps_what_was_known(tmp_path: Path) -> None:
    class Gone(ThreadPoolExecutor):
        left = 2

        def submit(self, function, /, *arguments, **named):  # type: ignore[no-untyped-def]
            self.left -= 1
            if self.left >= 0:
                return super().submit(function, *arguments, **named)
            future: Future[object] = Future()
            future.set_exception(OSError("connection reset by peer"))
            return future

    out, first = tmp_path / "found.jsonl", [Gone(1)]

    def connect() -> Executor:
        if not first:
            raise InputError("no scheduler answers")
        return first.pop()

    with pytest.raises(InputError, match="no scheduler answers"):
        drystone.check_many(MODELS, out=out, friction=0.6, executor=connect)
    assert len(out.read_text(encoding="utf-8").splitlines()) == 3
    again = drystone.check_many(MODELS, out=out, friction=0.6)
    assert again["verdict"].tolist() == VERDICTS
