"""The same plan with no worker, one that dies, a cluster, and after an interruption."""

import functools
import os
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from drystone.base.errors import FormatError, InputError
from drystone.cli import main
from drystone.detection import find_contacts
from drystone.io import write
from drystone.model import Model
from drystone.models import arch
from drystone.results import Result
from drystone.sequence import (
    DaskWorkers,
    Evaluator,
    LocalWorkers,
    Plan,
    PlanOptions,
    Rules,
    Stage,
    StagedModel,
    check_once,
    plan,
)
from drystone.stability.problem import Problem


def arch_plan(**arguments: object) -> Plan:
    assembly = arch(0.3, 7)
    contacts = find_contacts(assembly, friction=0.4).contacts
    options = PlanOptions(rules=Rules(hands=1))
    return plan(Model(assembly, contacts), options=options, **arguments)  # type: ignore[arg-type]


def essence(found: Plan) -> object:
    """What must not depend on how it was worked out."""
    return [
        (step.blocks, step.props, step.answer.verdict, step.answer.force.tobytes())
        for step in found.steps
    ]


@pytest.fixture(scope="module")
def alone() -> object:
    return essence(arch_plan())


def slowly(model: Model) -> Result:
    """A check of the caller's own: no quick look comes before it."""
    return check_once(model)


@pytest.fixture(scope="module")
def checked() -> object:
    return essence(arch_plan(check=slowly))


def test_a_quick_look_leads_to_the_plan_of_the_check_itself(alone, checked):
    assert [step[:3] for step in alone] == [step[:3] for step in checked]
    for ours, his in zip(alone, checked, strict=True):
        force, theirs = np.frombuffer(ours[3]), np.frombuffer(his[3])
        assert np.allclose(force, theirs, rtol=0.0, atol=1e-8 * abs(theirs).max())


def planned_in_haste(**options: object) -> Plan:
    """A plan whose patience ends, of which what it asked for decides when."""
    assembly = arch(0.3, 9)
    contacts = find_contacts(assembly, friction=0.4).contacts
    return plan(Model(assembly, contacts), options=PlanOptions(patience=8.0), **options)  # type: ignore[arg-type]


def test_a_part_is_built_once_for_a_quick_look_and_its_check(monkeypatch):
    structure = StagedModel(Model.of(arch(0.3, 7), friction=0.6))
    built = []
    build = Problem.build
    monkeypatch.setattr(Problem, "build", lambda model: built.append(model) or build(model))
    whole = Stage(structure.everything)
    with Evaluator(structure) as evaluator:
        assert evaluator.answer(whole._replace(quick=True)).stands
        assert evaluator.answer(whole, checked=True).stands
    assert len(built) == 1


def test_what_workers_look_at_in_vain_does_not_cost_patience():
    with ThreadPoolExecutor(4) as executor:
        together = planned_in_haste(executor=executor)
    one = planned_in_haste()
    assert together.solved > one.solved
    assert essence(together) == essence(one)


def test_what_a_checkpoint_knows_costs_patience_as_before(tmp_path):
    file = tmp_path / "stages.json"
    first, again = (planned_in_haste(checkpoint=file) for _ in range(2))
    assert again.solved < first.solved
    assert [step[:3] for step in essence(again)] == [step[:3] for step in essence(first)]


def mortal(marker: Path, parent: int, model: Model) -> Result:
    """Kills the first other process that it runs in."""
    if os.getpid() != parent and not marker.exists():
        marker.touch()
        os._exit(13)
    return check_once(model)


def test_a_worker_that_is_killed_is_replaced_and_gives_the_same_plan(checked, tmp_path):
    marker = tmp_path / "died"
    check = functools.partial(mortal, marker, os.getpid())
    assert essence(arch_plan(check=check, executor=LocalWorkers(1))) == checked
    assert marker.exists()


STARTS_A_WORKER = """
import os, time
from drystone.base.workers import LocalWorkers
if __name__ == "__main__":
    with LocalWorkers(1)() as workers:
        print(workers.submit(os.getpid).result(), flush=True)
        time.sleep(60)
"""


@pytest.mark.skipif(os.name == "nt", reason="processes that are killed")
def test_workers_end_when_the_process_that_started_them_is_killed(tmp_path):
    script = tmp_path / "starts.py"
    script.write_text(STARTS_A_WORKER, encoding="utf-8")
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE) as starter:
        assert starter.stdout is not None
        worker = int(starter.stdout.readline())
        starter.kill()
    for _ in range(200):
        try:
            os.kill(worker, 0)
        except ProcessLookupError:
            return
        time.sleep(0.02)
    pytest.fail("the worker goes on")


class Mortal(ThreadPoolExecutor):
    """An executor that breaks after some work, for good."""

    left = 3
    error: Exception = BrokenExecutor("a worker was killed")

    def submit(self, function, /, *arguments, **named):  # type: ignore[no-untyped-def]
        self.left -= 1
        if self.left < 0:
            future: Future = Future()
            future.set_exception(self.error)
            return future
        return super().submit(function, *arguments, **named)


def test_a_given_executor_that_breaks_is_done_without(alone):
    with Mortal(2) as executor:
        assert essence(arch_plan(executor=executor)) == alone


def test_new_workers_are_started_for_dead_ones(alone):
    started = []

    def start() -> Mortal:
        started.append(Mortal(2))
        return started[-1]

    assert essence(arch_plan(executor=start)) == alone
    assert len(started) > 1


def test_a_scheduler_that_dies_for_good_is_done_without(alone):
    class Gone(Mortal):
        error = OSError("connection reset by peer")

    first = [Gone(2)]

    def connect() -> Mortal:
        if not first:
            raise InputError("no scheduler answers")
        return first.pop()

    assert essence(arch_plan(executor=connect)) == alone


CALLS = {"left": 0}


def interrupted(model: Model) -> Result:
    """Ctrl-C after some stages."""
    CALLS["left"] -= 1
    if CALLS["left"] < 0:
        raise KeyboardInterrupt
    return check_once(model)


def test_an_interrupted_plan_goes_on_from_its_checkpoint(checked, tmp_path):
    file = tmp_path / "stages.json"
    CALLS["left"] = 6
    with pytest.raises(KeyboardInterrupt):
        arch_plan(check=interrupted, checkpoint=file)
    assert len(file.read_text().splitlines()) == 1 + 6
    CALLS["left"] = 1000
    assert essence(arch_plan(check=interrupted)) == checked
    whole = 1000 - CALLS["left"]
    CALLS["left"] = 1000
    assert essence(arch_plan(check=interrupted, checkpoint=file)) == checked
    # forces are not kept: stages of the plan itself are checked again for them, others are not
    assert 1000 - CALLS["left"] < whole


def test_an_interrupted_plan_with_quick_looks_ends_with_the_same_order_and_help(alone, tmp_path):
    file = tmp_path / "stages.json"

    def stop(stage: str, done: int, total: int) -> None:
        if done >= 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        arch_plan(checkpoint=file, progress=stop)
    assert len(file.read_text().splitlines()) > 1
    found = essence(arch_plan(checkpoint=file))
    assert [step[:3] for step in found] == [step[:3] for step in alone]


def test_a_checkpoint_of_another_model_is_refused(tmp_path):
    file = tmp_path / "stages.json"
    arch_plan(checkpoint=file)
    assembly = arch(0.25, 7)
    contacts = find_contacts(assembly, friction=0.4).contacts
    with pytest.raises(FormatError, match="model differ"):
        plan(Model(assembly, contacts), checkpoint=file)


@pytest.mark.parametrize("text", ["{", "[]", '{"format": "x"}', '{"format": "drystone-stages"}'])
def test_a_broken_checkpoint_is_named(tmp_path, text):
    file = tmp_path / "stages.json"
    file.write_text(text)
    with pytest.raises(FormatError, match=r"stages\.json"):
        arch_plan(checkpoint=file)


@pytest.mark.filterwarnings("ignore")  # of the cluster, about ports and shutdown
def test_a_dask_cluster_gives_the_same_plan_and_the_same_data_set(alone, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None,
        host="127.0.0.1", protocol="tcp",
    ) as cluster:  # fmt: skip
        assert essence(arch_plan(executor=DaskWorkers(cluster.scheduler_address))) == alone
        write(arch(0.3, 5), tmp_path / "arch.json")
        asked = ["dataset", str(tmp_path / "arch.json"), "--rows", "30", "--out"]
        assert main([*asked, str(tmp_path / "alone")]) == 0
        future = DaskWorkers(cluster.scheduler_address)().submit(time.sleep, 0.2)
        with pytest.raises(TimeoutError):
            future.result(timeout=0.01)
        assert type(future) is Future  # whose wait cancels nothing when it is given up
        assert future.result() is None
        cluster_too = [str(tmp_path / "side by side"), "--workers", cluster.scheduler_address]
        assert main([*asked, *cluster_too]) == 0
    one, other = (
        tmp_path / name / "orders" / "00000.journal" for name in ("alone", "side by side")
    )
    assert one.read_bytes() == other.read_bytes()


@pytest.mark.filterwarnings("ignore")
def test_a_silent_dask_address_is_named():
    pytest.importorskip("distributed")
    with pytest.raises(InputError, match="no Dask scheduler"):
        DaskWorkers("tcp://127.0.0.1:9", timeout_s=0.5)()


def test_workers_that_are_busy_do_not_keep_a_program_that_has_ended_early() -> None:
    code = (
        "import time\n"
        "from drystone.base.workers import LocalWorkers, WorkerPool\n"
        "if __name__ == '__main__':\n"
        "    begin = time.monotonic()\n"
        "    late = lambda: time.monotonic() > begin + 2.0\n"
        "    with WorkerPool(LocalWorkers(2)) as pool:\n"
        "        print(list(pool.answers(time.sleep, [300.0, 300.0], late)))\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60.0, check=True
    )
    assert run.stdout == "[]\n"
    assert run.stderr == ""
