"""What all tests share; read before any of them imports numpy."""

import functools
import gc
import os
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest

# The tests run side by side: threads of linear algebra would only wait for each other.
for threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
for size in ("COLUMNS", "LINES"):  # of the terminal of who runs them: tables would depend on it
    os.environ.pop(size, None)

# Each process that a test starts would compile all that it imports, and each worker all tests.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

WORKER = os.environ.get("PYTEST_XDIST_WORKER", "")
if WORKER:  # what is read while tests are collected is no garbage
    gc.disable()

if os.name == "nt":  # these limit the size of files, the memory or the time of processes
    collect_ignore = ["unit/cli/test_full_disk.py", "unit/test_benchmark_speed.py"]

SLOW = {"benchmarks", "cli", "compat", "design", "fall", "limits", "live", "mcp", "models"}
SLOW |= {"report", "seismic", "sequence", "settlement", "shells", "studies", "view"}
SLOW |= {"test_answers.py", "test_benchmark_speed.py", "test_bricks.py", "test_display.py"}
SLOW |= {"test_both_carriers.py", "test_dxf.py", "test_fine_meshes.py", "test_journals.py"}
SLOW |= {"test_meeting.py", "test_near_pairs.py", "test_scenes.py", "test_simulators.py"}
SLOW |= {"test_assembly_env.py", "test_boxes.py", "test_force_states.py", "test_imports.py"}
SLOW |= {"test_inexact_joints.py", "test_mesh_objects.py", "test_unfolding.py", "test_words.py"}
SLOW |= {"test_documentation.py", "test_freeform.py", "test_numerical_trouble.py"}
SLOW |= {"test_public_api.py", "test_stopping.py", "test_settled_verdicts.py", "test_curved.py"}
SLOW |= {
    "test_check_many.py",
    "test_hostile.py",
    "test_long_work.py",
    "test_resting.py",
    "test_rhino.py",
}
"""Of tests/unit: what takes longer than the quick look of ``pytest -m fast`` may."""


@functools.cache
def is_fast(path: Path) -> bool:
    """Whether a file or folder of tests may hold what a person runs while writing."""
    unit = Path(__file__).parent / "unit"
    return path == unit or (unit in path.parents and SLOW.isdisjoint(path.relative_to(unit).parts))


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Files that ``pytest -m fast`` does not run are not even read: that took half of its time."""
    inside = Path(__file__).parent in collection_path.parents
    skipped = config.option.markexpr == "fast" and inside and not is_fast(collection_path)
    return True if skipped else None


class Backwards(pytest.Dir):
    """A folder whose last file is read first."""

    def collect(self) -> Iterable[pytest.Collector]:
        return reversed([*super().collect()])


def pytest_collect_directory(path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Every other worker reads from the end: half of the tests were compiled by its neighbour."""
    return Backwards.from_parent(parent, path=path) if WORKER[-1:] in {*"13579"} else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """In the same order in every worker; marked what a person runs while writing."""
    items.sort(key=lambda item: item.path)
    for item in items:
        if is_fast(item.path):
            item.add_marker(pytest.mark.fast)


@pytest.hookimpl(trylast=True)
def pytest_collection_finish(session: pytest.Session) -> None:
    """What was read stays until the end: the collector of garbage need not look at it again."""
    gc.freeze()
    gc.set_threshold(10_000, 10, 10)
    gc.enable()


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are drawn without pixels, which take half of a report: the test reads its words."""
    from drystone.report.sketches import signs_picture

    signs_picture()  # that one is kept for later reports
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda *_, **__: None)
