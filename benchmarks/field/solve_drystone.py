"""drystone as a solver of the benchmark: ``check`` with its defaults."""

from __future__ import annotations

import time

import drystone
from drystone import Verdict
from drystone.base.version import commit

from .tasks import answer_all, model_of

KNOWN = {Verdict.STABLE: True, Verdict.UNSTABLE: False}


def solve(task):
    model = model_of(task)
    began = time.process_time()
    found = drystone.check(model)
    seconds = time.process_time() - began
    return KNOWN.get(found.verdict), found.message, seconds


if __name__ == "__main__":
    answer_all(f"drystone {drystone.__version__}, commit {commit()}", solve, dry_only=False)
