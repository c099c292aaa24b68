"""MuJoCo as a solver of the benchmark: two seconds of motion from rest (extra ``fall``).

It falls where a block moves by more than a tenth of its size, and stands where none moves by more
than a fiftieth. Between them it is no answer: MuJoCo's contacts are soft and creep.
"""

from __future__ import annotations

import time

import mujoco

from benchmarks.field.tasks import answer_all, model_of
from benchmarks.replay import moved

FALLS, STANDS = 0.1, 0.02


def solve(task):
    model = model_of(task)
    began = time.process_time()
    far = moved(model, 0.005)
    seconds = time.process_time() - began
    known = True if far < STANDS else False if far > FALLS else None
    return known, f"moved by {far:.2g} of its size", seconds


if __name__ == "__main__":
    answer_all(f"MuJoCo {mujoco.__version__}", solve)
