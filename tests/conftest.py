"""What all tests share; read before any of them imports numpy."""

import os
from pathlib import Path

import pytest

# The tests run side by side: threads of linear algebra would only wait for each other.
for threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

SLOW = {"benchmarks", "cli", "compat", "design", "fall", "limits", "live", "mcp", "models"}
SLOW |= {"sequence", "settlement", "shells", "view", "test_benchmark_speed.py", "test_display.py"}
SLOW |= {"test_documentation.py", "test_freeform.py", "test_numerical_trouble.py"}
SLOW |= {"test_public_api.py", "test_stopping.py", "test_settled_verdicts.py", "test_curved.py"}
SLOW |= {"test_check_many.py", "test_hostile.py", "test_rhino.py"}
"""Of tests/unit: what takes longer than the quick look of ``pytest -m fast`` may."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that a person runs while writing: ``pytest -m fast``."""
    unit = Path(__file__).parent / "unit"
    for item in items:
        if unit in item.path.parents and SLOW.isdisjoint(item.path.relative_to(unit).parts):
            item.add_marker(pytest.mark.fast)
