"""Jobs of the process that computes: interrupted where they are, and only the one that is meant."""

import multiprocessing
import threading
import time
from collections.abc import Iterator
from multiprocessing.connection import Connection

import pytest

from drystone.live.tasks import Jobs


@pytest.fixture
def server() -> Iterator[tuple[Connection, Jobs]]:
    """The end of the server, and the jobs that come through it."""
    ours, theirs = multiprocessing.Pipe()
    gone = threading.Event()
    yield ours, Jobs(theirs, gone.set)
    ours.close()
    assert gone.wait(60.0)
    theirs.close()


def test_a_server_that_was_killed_is_told_nothing_and_that_is_no_error() -> None:
    ours, theirs = multiprocessing.Pipe()
    gone = threading.Event()
    jobs = Jobs(theirs, gone.set)
    ours.close()
    assert gone.wait(60.0)
    gone.clear()
    jobs.send({"event": "ready"})
    assert gone.is_set()
    theirs.close()


def busy(seconds: float) -> None:
    """Work that never asks whether it is wanted."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        sum(range(100))


def test_a_cancelled_job_is_interrupted_where_it_is(server: tuple[Connection, Jobs]) -> None:
    pipe, jobs = server
    done: list[int] = []
    threading.Timer(0.1, pipe.send, [{"cancel": 1}]).start()
    began = time.monotonic()
    jobs.do(1, lambda: (busy(60.0), done.append(1)))
    assert time.monotonic() - began < 30.0
    assert not done
    jobs.do(2, lambda: done.append(2))  # the next one is not
    assert done == [2]


def test_a_job_that_was_cancelled_before_it_begins_is_left_out(
    server: tuple[Connection, Jobs],
) -> None:
    pipe, jobs = server
    pipe.send({"cancel": 3})
    pipe.send({"job": 4})
    assert jobs.next() == {"job": 4}  # the message before was read by then
    done: list[int] = []
    jobs.do(3, lambda: done.append(3))
    jobs.do(4, lambda: done.append(4))
    assert done == [4]


def test_many_cancelled_jobs_end_no_other_and_tear_no_answer(
    server: tuple[Connection, Jobs],
) -> None:
    pipe, jobs = server
    ended: list[int] = []

    def work(job: int) -> None:
        for _ in range(20):
            jobs.send({"job": job})
        ended.append(job)

    heard: list[int] = []
    stopped = threading.Event()

    def hear() -> None:
        while not stopped.is_set() or pipe.poll():
            if pipe.poll(0.01):
                heard.append(pipe.recv()["job"])

    listener = threading.Thread(target=hear)
    listener.start()
    for job in range(1, 201):
        if job % 2:
            threading.Thread(target=pipe.send, args=[{"cancel": job}]).start()
        jobs.do(job, lambda job=job: work(job))
    stopped.set()
    listener.join()
    for job in range(2, 201, 2):
        assert job in ended
        assert heard.count(job) == 20
