"""Plans replayed in MuJoCo, stage by stage: ``python -m benchmarks.replay`` (extra ``fall``).

Every stage of a plan is simulated for two seconds with the blocks that are in place, held and
propped ones fixed. It stays when no block moves by more than a hundredth of its size. MuJoCo's
contacts are soft and creep (docs/reference/robots.md): a stage that does not stay is simulated
again with contacts and time steps of a twentieth.
With ``--rows FILE`` every stage is kept as soon as it is known, and a later run goes on from there.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import time
from pathlib import Path

import mujoco
import numpy as np

from benchmarks.field.solve_mujoco import moved
from benchmarks.machine import description
from benchmarks.niche import niche
from benchmarks.sequence import BY_COURSE, DOME_FRICTION, VAULT_FRICTION
from benchmarks.tables import TABLES, write_table
from drystone import Model
from drystone.base.files import write_bytes
from drystone.io.mjcf import mjcf_text
from drystone.models import bridge
from drystone.reproduce.assembly_cases import ring_dome
from drystone.sequence import Plan, PlanOptions, plan

STAYS = 0.01
"""Largest displacement by the size of a block; after ``SECONDS`` of simulated time."""
CONTACT = {"bridge": 0.005, "vault": 0.01, "dome": 0.01, "dome-0.75": 0.01}
"""[s], time constant of contacts. The bridge creeps with a large one, many contacts need one."""
STIFFER = 20.0
"""Divides it where a stage does not stay: blocks creep in proportion to it."""


def stages(found: Plan) -> list[tuple[str, Model]]:
    """Models of all stages: after every block, held and propped blocks fixed."""
    model = found.model.model
    names = model.assembly.names
    out = []
    placed = set(np.flatnonzero(model.assembly.fixed).tolist())
    for number, step in enumerate(found.steps):
        before = set(found.steps[number - 1].props) if number else set()
        held: set[int] = set()
        for place, block in enumerate(step.blocks):
            placed.add(block)
            last = place == len(step.blocks) - 1
            held = set() if last else held | {block}
            props = set(step.props) if last else before | set(step.props)
            fixed = np.flatnonzero(model.assembly.fixed).tolist()
            still = sorted({*fixed, *held, *(props & placed)})
            some = model.with_supports(still).subset(sorted(placed))
            out.append((names[block], some))
    return out


def replay(name: str, found: Plan, contact_s: float, kept: Path | None) -> str:
    """A row of the table; stages in the file ``kept`` of an earlier run are not simulated again."""
    rows = json.loads(kept.read_text("utf-8")) if kept is not None and kept.exists() else {}
    far: dict[str, float] = {}
    spent, again = 0.0, 0
    for block, some in stages(found):
        stage = hashlib.sha256(mjcf_text(some, contact_s=contact_s).encode()).hexdigest()[:16]
        if stage not in rows:
            began = time.process_time()
            rows[stage] = {
                "plan": name,
                "block": block,
                "moved": moved(some, contact_s),
                "cpu_s": time.process_time() - began,
            }
            if kept is not None:
                write_bytes(kept, json.dumps(rows, indent=1).encode())
        if rows[stage]["moved"] > STAYS and "stiffer" not in rows[stage]:
            began = time.process_time()
            rows[stage]["stiffer"] = moved(some, contact_s / STIFFER)
            rows[stage]["cpu_s"] += time.process_time() - began
            if kept is not None:
                write_bytes(kept, json.dumps(rows, indent=1).encode())
        again += "stiffer" in rows[stage]
        far[block] = rows[stage].get("stiffer", rows[stage]["moved"])
        spent += rows[stage]["cpu_s"]
    counts = found.counts
    worst = max(far, key=far.__getitem__)
    return (
        f"| {name} | {len(found.model.assembly.free)} | {counts['free']} | {counts['held']} "
        f"| {counts['propped']} | {contact_s:g} | {len(far)} "
        f"| {again} | {sum(one <= STAYS for one in far.values())} | {far[worst]:.1e} | {worst} "
        f"| {spent:.0f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="bridge, vault, dome, dome-0.75")
    parser.add_argument("--rows", type=Path, help="keep every stage in this file, and go on there")
    arguments = parser.parse_args()
    best = PlanOptions(patience=math.inf)
    course = PlanOptions(rules=BY_COURSE)
    plans = {
        "bridge": lambda: plan(Model.of(bridge(), friction=0.66), options=best),
        "vault": lambda: plan(Model.of(niche(0.2), friction=VAULT_FRICTION), options=course),
        "dome": lambda: plan(Model.of(ring_dome(), friction=DOME_FRICTION), options=course),
        "dome-0.75": lambda: plan(Model.of(ring_dome(), friction=0.75), options=course),
    }
    lines = [
        "| plan | blocks | free | held | propped | contact [s] | stages | stiffer | stay "
        "| largest move / size | at | time [s] |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name in arguments.names or plans:
        lines.append(replay(name, plans[name](), CONTACT[name], arguments.rows))
        print(lines[-1], flush=True)
    print(f"MuJoCo {mujoco.__version__}. Measured with {description()}")
    if not arguments.names:
        write_table(TABLES / "replay.csv", lines)


if __name__ == "__main__":
    main()
