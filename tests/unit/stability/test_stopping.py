"""Stopped from outside or by the time: with what is known, and nothing that is not."""

import os
import signal
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import pytest
from scipy import sparse

from drystone import LoadCase, Result, Verdict, find_contacts, models
from drystone.base.settings import Clock
from drystone.model import Model
from drystone.programs import RBEOptions, solve_cra, solve_cra_penalty, solve_rbe
from drystone.solvers.program import Cones, ConicOptions, ConicStatus, prepared, solution
from drystone.stability import CheckOptions, check, try_rest

ARCH = models.arch(0.15)
JOINTS = find_contacts(ARCH, friction=0.9).contacts
FALLING = LoadCase.tilt(ARCH, (0.0, 1.0, 0.0), 40.0)
INTERRUPTED = "it was interrupted"


@pytest.fixture
def interrupts() -> Iterator[None]:
    """Python's own handler: a suite that was started in the background ignores Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def after(calls: int) -> Callable[[], bool]:
    """Says so once only: who hears it must remember."""
    left = iter([False] * calls + [True])
    return lambda: next(left, False)


def stopped(
    analyse: Callable[..., Result], load: LoadCase | None = None
) -> list[tuple[int, Result]]:
    """The answers when it is stopped ever later, up to the one that is not stopped."""
    answers = []
    for calls in (0, 2, 8, 16, 32, 64, 1000):
        answers.append((calls, analyse(Model(ARCH, JOINTS, load), stop=after(calls))))
        if not answers[-1][1].stopped:
            return answers
    raise AssertionError("it never came to an end")


def test_a_check_stopped_later_knows_more():
    robust = partial(check, options=CheckOptions.robust())
    answers = [answer for _, answer in stopped(robust)]
    assert answers[0].verdict is Verdict.UNDECIDED
    assert answers[0].samples.tried == 0
    assert "interrupted in 'rest state' (steps: " in answers[0].message
    tried = [answer.samples.tried for answer in answers]
    assert tried == sorted(tried)
    assert tried[-1] == 5
    assert any(0 < count < 5 for count in tried)
    for answer in answers[:-1]:
        assert answer.stopped == INTERRUPTED
        assert answer.samples.standing == answer.samples.tried
        assert (answer.verdict is Verdict.STABLE) == (answer.samples.tried > 0)
    first = next(answer for answer in answers if answer.samples.tried)
    left = 5 - first.samples.tried
    assert first.message.startswith("stands")
    assert first.message.endswith(f"; it was interrupted before {left} more could be tried")
    assert first.residuals is not None
    assert first.residuals.largest < 1e-8


def test_what_falls_is_unstable_only_with_its_proof():
    answers = [answer for _, answer in stopped(check, FALLING)]
    assert answers[0].verdict is Verdict.UNDECIDED
    assert answers[-1].verdict is Verdict.UNSTABLE
    for answer in answers:
        assert answer.verdict is not Verdict.STABLE
        assert (answer.mechanism is not None) == (answer.verdict is Verdict.UNSTABLE)


@pytest.mark.parametrize("analyse", [solve_cra, solve_rbe, solve_cra_penalty])
def test_every_analysis_can_be_stopped(analyse: Callable[..., Result]):
    for load, right in ((None, Verdict.UNSTABLE), (FALLING, Verdict.STABLE)):
        answers = stopped(analyse, load)
        assert answers[0][1].verdict is Verdict.UNDECIDED
        assert answers[0][1].stopped == INTERRUPTED
        assert INTERRUPTED in answers[0][1].message
        assert all(answer.verdict is not right for _, answer in answers)
        assert not answers[-1][1].stopped


def test_props_are_not_told_before_they_are_known():
    for _, answer in stopped(solve_cra_penalty, FALLING)[:-1]:
        assert "before the help that it needs was known" in answer.message
        assert answer.tension is None


def test_rest_stopped_at_once_is_undecided():
    found = try_rest(Model(ARCH, JOINTS), stop=lambda: True)
    assert (found.verdict, found.stopped) == (Verdict.UNDECIDED, INTERRUPTED)
    assert found.samples.tried == 0


def test_equilibrium_without_time_says_so():
    options = RBEOptions(conic=ConicOptions(time_limit_s=0.0))
    found = solve_rbe(Model(ARCH, JOINTS), options=options)
    assert found.verdict is Verdict.UNDECIDED
    assert found.message == "the time was up in the interior point (steps: 0)"


def test_a_clock_that_was_late_stays_late():
    clock = Clock(float("inf"), after(1))
    assert [clock.late() for _ in range(4)] == [False, True, True, True]
    assert clock.reason == INTERRUPTED


def program(stop: Callable[[], bool] | None) -> ConicStatus:
    """A small quadratic program of some ten steps."""
    rng = np.random.default_rng(0)
    rows = sparse.csc_matrix(rng.standard_normal((60, 20)))
    cones = Cones(nonnegative=60)
    solver = prepared(np.ones(20), rng.standard_normal(20), rows, np.ones(60), cones)
    return solution(solver, stop).status


def test_a_program_ends_where_it_is_told_to():
    assert program(None) is ConicStatus.SOLVED
    assert program(after(2)) is ConicStatus.FAILED


def test_what_stop_raises_comes_through(capfd: pytest.CaptureFixture[str]):
    def stop() -> bool:
        raise ValueError("out of the solver")

    with pytest.raises(ValueError, match="out of the solver"):
        program(stop)
    assert capfd.readouterr() == ("", "")


@pytest.mark.skipif(os.name == "nt", reason="there os.kill ends the process")
def test_an_interrupt_within_a_program_is_raised_and_breaks_nothing(
    capfd: pytest.CaptureFixture[str], interrupts: None
):
    def stop() -> bool:
        os.kill(os.getpid(), signal.SIGINT)
        return False

    with pytest.raises(KeyboardInterrupt):
        check(Model(ARCH, JOINTS, FALLING), stop=stop)
    with pytest.raises(KeyboardInterrupt):
        program(stop)
    assert capfd.readouterr() == ("", "")
    assert program(None) is ConicStatus.SOLVED
    assert check(Model(ARCH, JOINTS)).verdict is Verdict.STABLE
