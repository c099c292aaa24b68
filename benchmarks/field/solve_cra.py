"""compas_cra as a solver of the benchmark, run by the Python of an environment that has it.

``PYTHON -m benchmarks.field.solve_cra`` in the root of the repository. Imports nothing of drystone.
The interfaces are those of the task. It falls where IPOPT finds the program infeasible.
"""

from __future__ import annotations

from importlib.metadata import version

from benchmarks.cra_peer import solve as cra_solve
from benchmarks.field.tasks import answer_all


def solve(task):
    said, seconds = cra_solve(task)
    known = True if said == "solved" else False if "Infeasible_Problem_Detected" in said else None
    return known, said, seconds


if __name__ == "__main__":
    answer_all(f"compas_cra {version('compas_cra')}", solve)
