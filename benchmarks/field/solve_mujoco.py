"""MuJoCo as a solver of the benchmark: two seconds of motion from rest (extra ``fall``).

It falls where a block moves by more than a tenth of its size, and stands where none moves by more
than a fiftieth. Between them it is no answer: MuJoCo's contacts are soft and creep.
"""

from __future__ import annotations

import time

import mujoco
import numpy as np

from drystone import Model
from drystone.io.mjcf import mjcf_text

from .tasks import answer_all, model_of

FALLS, STANDS = 0.1, 0.02
CONTACT_S = 0.005
"""Time constant of contacts [s]: the smallest that its documentation allows for steps of 2 ms."""
SECONDS = 2.0
"""Simulated time."""
STEPS = 5.0
"""Time steps per time constant of contacts; MuJoCo's documentation asks for two at least."""


def moved(model: Model, contact_s: float, seconds: float = SECONDS) -> float:
    """Largest displacement of a free block after some time, by its size."""
    simulator = mujoco.MjModel.from_xml_string(mjcf_text(model, contact_s=contact_s))
    simulator.opt.timestep = contact_s / STEPS
    data = mujoco.MjData(simulator)
    mujoco.mj_forward(simulator, data)
    start = np.array(data.xpos)
    for _ in range(round(seconds / simulator.opt.timestep)):
        mujoco.mj_step(simulator, data)
    gone = np.linalg.norm(data.xpos - start, axis=1)[1:]
    return float((gone / model.assembly.size)[model.assembly.free].max(initial=0.0))


def solve(task):
    model = model_of(task)
    began = time.process_time()
    far = moved(model, CONTACT_S)
    seconds = time.process_time() - began
    known = True if far < STANDS else False if far > FALLS else None
    return known, f"moved by {far:.2g} of its size", seconds


if __name__ == "__main__":
    answer_all(f"MuJoCo {mujoco.__version__}", solve)
