"""LMGC90 by compas_lmgc90 as a solver of the benchmark: two seconds of motion from rest.

``PYTHON solve_lmgc90.py`` in an environment that has it; imports nothing of drystone. Non-smooth
contact dynamics with Coulomb friction, law ``IQS_CLB_g0`` as in the example of the package, time
step 5 ms. Thresholds of falling and standing as for MuJoCo. Its blocks are convex: others are no
answer.
"""

from __future__ import annotations

import time
from importlib.metadata import version

import numpy as np
from compas_lmgc90.solver import Solver
from tasks import answer_all

FALLS, STANDS = 0.1, 0.02
STEP, STEPS = 0.005, 400


def convex(block):
    """Whether no vertex is in front of a face."""
    points = np.array(block["vertices"])
    for face in block["faces"]:
        corner = points[face]
        normal = sum(np.cross(a, b) for a, b in zip(corner, np.roll(corner, -1, 0), strict=True))
        if ((points - corner[0]) @ normal > 1e-6 * np.linalg.norm(normal)).any():
            return False
    return True


def solve(task):
    if not all(convex(block) for block in task["blocks"]):
        return None, "a block is not convex", None
    began = time.process_time()
    solver = Solver(dt=STEP)
    solver.geometry_from_v_f(task["blocks"], density=2400.0)
    for block in task["fixed"]:
        for component in ("Vx", "Vy", "Vz", "Rx", "Ry", "Rz"):
            solver.apply_velocity(block, component, 0.0)
    solver.contact_law("IQS_CLB_g0", task["friction"])
    solver.preprocess()
    start = np.array([mesh.centroid() for mesh in solver.trimeshes])
    solver.run(nb_steps=STEPS)
    end = np.array([mesh.centroid() for mesh in solver.trimeshes])
    sizes = [np.ptp(np.array(block["vertices"]), axis=0).max() for block in task["blocks"]]
    far = (np.linalg.norm(end - start, axis=1) / sizes).max()
    seconds = time.process_time() - began
    known = True if far < STANDS else False if far > FALLS else None
    return known, f"moved by {far:.2g} of its size", seconds


if __name__ == "__main__":
    answer_all(f"LMGC90, compas_lmgc90 {version('compas_lmgc90')}", solve)
