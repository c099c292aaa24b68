"""compas_cra as a solver of the benchmark: ``PYTHON solve_cra.py`` in an environment that has it.

Imports nothing of drystone. The interfaces are those of the task. It falls where IPOPT finds the
program infeasible.
"""

from __future__ import annotations

from importlib.metadata import version

from cra_peer import solve as cra_solve
from tasks import answer_all


def solve(task):
    said, seconds = cra_solve(task)
    known = True if said == "solved" else False if "Infeasible_Problem_Detected" in said else None
    return known, said, seconds


if __name__ == "__main__":
    answer_all(f"compas_cra {version('compas_cra')}", solve)
