"""What a process holds is counted, and what grows is told."""

import tempfile
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.lasting import A_ROUND, SETTLED, Held, faults

pytestmark = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="Linux tells")


def test_a_file_a_thread_and_a_temporary_file_that_are_left_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    before = Held.now()
    ends = threading.Event()
    thread = threading.Thread(target=ends.wait)
    thread.start()
    with tempfile.NamedTemporaryFile():
        after = replace(Held.now(), memory=before.memory)
    ends.set()
    thread.join()
    assert faults([(1, before), (2, after)]) == ["threads", "files", "left"]


def test_memory_may_grow_by_so_much_a_round(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # what else is there takes long
    before = Held.now()
    for more, told in ((10 * A_ROUND, []), (10 * A_ROUND + 1, ["memory"])):
        after = replace(before, memory=before.memory + more)
        assert faults([(1, after), (SETTLED, before), (SETTLED + 10, after)]) == told
        assert faults([(1, before), (SETTLED - 1, before), (SETTLED + 9, after)]) == []
