"""Degenerate assemblies: each gets a verdict with a proof, or one clear error, soon.

``python -m benchmarks.degenerate [--assemblies 10000] [--seed 0]``

One to six random blocks: flat, thin, sharp, nearly without volume, twice in one place, inside each
other, with gaps and overlaps of all sizes, turned a little, far from the origin, of sizes that
differ by up to a million, and whole assemblies at the ends of what a float holds. Friction and
loads are as odd. Each assembly gets 10 CPU s, and 2 GiB are all that may be allocated. Warnings are
errors.

Every answer is held against RBE by lines that share nothing with it
(:mod:`benchmarks.any_forces`): the forces of what stands balance, press and stay in their cones, no
velocities prove that there are none, and what RBE calls unstable has velocities that prove it.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
import warnings
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from benchmarks.any_forces import fault_of_forces, proven_none, proves_none
from benchmarks.fuzz import TooSlowError, _deadline, _limited_memory, _restore_memory
from drystone import Assembly, LoadCase, Model, check, solve_rbe
from drystone.assembly import Block
from drystone.base.errors import InputError
from drystone.geometry.frames import rotation_about
from drystone.models import box, prism, welded
from drystone.results import Result, Verdict

LIMIT_S = 10.0
MEMORY = 2 * 2**30
"""[bytes]"""
TINY = (0.0, 0.0, 0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, -1e-9, -1e-6, -1e-4, -0.1)
"""Gaps between blocks, by their size; overlaps are below zero."""


@dataclass
class Tally:
    """What became of the assemblies.

    Attributes
    ----------
    outcomes
        Number by kind of outcome.
    against
        Number by verdict, verdict of RBE, and what the linear program found.
    proofs
        Number of mechanisms of RBE by whether they prove by themselves that there are no forces.
    failures
        Each the number of the assembly and what went wrong.
    slowest
        CPU time [s] and number.
    """

    outcomes: Counter[str] = field(default_factory=Counter)
    against: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    proofs: Counter[bool] = field(default_factory=Counter)
    failures: list[tuple[int, str]] = field(default_factory=list)
    slowest: tuple[float, int] = (0.0, -1)


def odd_block(rng: random.Random, name: str, size: float) -> Block:
    """One block about the origin, of an extent of about ``size``."""
    kind = rng.randrange(6)
    thin = 10.0 ** rng.uniform(-9.0, 0.0)
    density = rng.choice((2400.0, 2400.0, 1e-9, 1e12, 10.0 ** rng.uniform(-3.0, 6.0)))
    if kind < 2:
        sides = [size * rng.choice((1.0, 1.0, thin, rng.uniform(0.1, 1.0))) for _ in range(3)]
        return box((sides[0], sides[1], sides[2]), (0.0, 0.0, 0.0), name, density)
    if kind == 2:
        top = rng.choice((0.5, 0.5 + thin, 0.5 - thin, thin, -thin))
        section = [(-0.5, 0.0), (0.5, 0.0), (top, 1.0), (-0.5, 1.0)]
        return prism(size * np.array(section), (0.0, size), name, density)
    if kind == 3:  # concave, with a slit
        slit = 0.5 * min(thin, 0.9)
        section = [(0, 0), (1, 0), (1, 1), (0.5 + slit, 1), (0.5, thin), (0.5 - slit, 1), (0, 1)]
        return prism(size * np.array(section), (0.0, size), name, density)
    if kind == 4:
        a, b, c = size * np.eye(3)
        d = size * np.array([1.0, 1.0, 1.0]) / 3.0 * (1.0 - thin)
        return welded([(a, b, c), (a, b, d), (b, c, d), (a, c, d)], name, density)
    count = rng.randrange(3, 40)
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return prism(
        size * np.stack([np.cos(angle), np.sin(angle)], axis=1), (0.0, size * thin), name, density
    )


def odd_model(rng: random.Random) -> Model:
    """One assembly with contacts, friction and a load.

    Raises
    ------
    InputError
        It is refused.
    """
    whole = 10.0 ** rng.choice((0.0, 0.0, 0.0, 0.0, rng.uniform(-9.0, 9.0), rng.uniform(-150, 150)))
    away = whole * rng.choice((0.0, 0.0, 0.0, 1e3, 1e6, 1e9))
    blocks = [box((3.0 * whole, 3.0 * whole, whole), (-whole, -whole, -whole), "ground")]
    height = 0.0
    for number in range(rng.randrange(1, 6)):
        size = whole * rng.choice((1.0, 1.0, 1.0, 10.0 ** rng.uniform(-6.0, 1.0)))
        block = odd_block(rng, f"b{number}", size)
        if rng.random() < 0.2:
            axis = [rng.uniform(-1.0, 1.0) for _ in range(3)]
            degrees = rng.choice((1e-9, 1e-6, 1e-3, 0.1, 90.0, rng.uniform(0.0, 360.0)))
            block = block.transformed(rotation_about(axis, degrees))
        low, high = block.vertices[:, 2].min(), block.vertices[:, 2].max()
        beside = rng.choice((0.0, 0.0, 0.0, size * rng.uniform(-1.0, 1.0)))
        rise = height + size * rng.choice(TINY)
        block = block.transformed(translation=(beside, 0.0, rise - low))
        if rng.random() > 0.1:
            height = rise + high - low
        blocks.append(block)
        if rng.random() < 0.03:
            blocks.append(block.transformed(translation=(0.0, 0.0, 0.0)).renamed(f"again {number}"))
    fixed = np.array([i == 0 or rng.random() < 0.1 for i in range(len(blocks))])
    if rng.random() < 0.03:
        fixed[:] = rng.random() < 0.5
    assembly = Assembly(tuple(blocks), fixed).transformed(translation=(away, -away, away))
    mu = rng.choice((0.6, 0.6, 0.0, 1e-12, 0.05, 3.0, 1e6))
    kind = rng.randrange(5)
    if kind < 2:
        return Model.of(assembly, friction=mu)
    if kind == 2:
        load = LoadCase.tilt(assembly, (1.0, rng.uniform(-1.0, 1.0), 0.0), rng.uniform(0.0, 180.0))
        return Model.of(assembly, friction=mu, load=load)
    strength = 9.81 * 10.0 ** rng.choice((0.0, -12.0, -30.0, 12.0, 30.0, rng.uniform(-150, 150)))
    return Model.of(assembly, friction=mu, load=(rng.choice((0.0, strength)), 0.0, -strength))


def against_rbe(found: Result, rbe: Result, tally: Tally) -> str:
    """What speaks against a verdict, and count how it compares; empty where nothing does."""
    none = proven_none(found.model)
    proof = "not asked" if none is None else "no forces" if none else "forces not excluded"
    tally.against[found.verdict.value, rbe.verdict.value, proof] += 1
    falls = False
    if rbe.mechanism is not None:
        velocity = rbe.mechanism.copy()
        velocity[:, 3:] *= np.array([one.size for one in rbe.model.assembly.blocks])[:, None]
        falls = proves_none(rbe.model, velocity.ravel())
        tally.proofs[falls] += 1
    if found.stable:
        fault = fault_of_forces(found)
        if fault:
            return f"STABLE with forces, but {fault}"
        if none or falls:
            return "STABLE, and no forces balance the loads"
    if rbe.verdict is Verdict.EQUILIBRIUM_EXISTS:
        fault = fault_of_forces(rbe) or (proven_none(rbe.model) and "none balance the loads")
        if fault:
            return f"forces of RBE, but {fault}"
    return ""


def one(number: int, seed: int, tally: Tally) -> None:
    """Build, check and note one assembly."""
    rng = random.Random(f"{seed}-{number}")
    begin = time.process_time()
    wrong = ""
    try:
        with _deadline(LIMIT_S, busy=True):
            model = odd_model(rng)
            found = check(model)
        outcome = found.verdict.value
        if found.falls and (found.mechanism is None or not np.isfinite(found.mechanism).all()):
            wrong = "UNSTABLE without a motion"
        wrong = wrong or against_rbe(found, solve_rbe(model), tally)
    except InputError as error:
        outcome = "refused"
        if "\n" in str(error):
            wrong = "error of several lines"
    except TooSlowError:
        outcome, wrong = "hang", f"more than {LIMIT_S:g} CPU s"
    except Exception as error:  # any other kind is what is looked for
        outcome, wrong = "other", f"{type(error).__name__}: {error}"
    tally.slowest = max(tally.slowest, (time.process_time() - begin, number))
    tally.outcomes[outcome] += 1
    if wrong:
        tally.failures.append((number, wrong))


def run(assemblies: int, seed: int, first: int = 0) -> Tally:
    """Check ``assemblies`` degenerate assemblies and tally what became of them."""
    tally = Tally()
    check(odd_model(random.Random("warm")))
    before = _limited_memory(MEMORY)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for number in range(first, first + assemblies):
                one(number, seed, tally)
    finally:
        _restore_memory(before)
    return tally


def main() -> int:
    """Run, print the counts, and fail where something else than an answer came back."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--assemblies", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    begin = time.perf_counter()
    tally = run(chosen.assemblies, chosen.seed, chosen.first)
    spent = time.perf_counter() - begin
    for kind, count in sorted(tally.outcomes.items()):
        print(f"{kind}: {count:,}")
    print(f"{sum(tally.outcomes.values()):,} assemblies in {spent:.0f} s, seed {chosen.seed}")
    print(f"the slowest took {tally.slowest[0]:.2f} CPU s (number {tally.slowest[1]})")
    for (verdict, rbe, proof), count in sorted(tally.against.items()):
        print(f"{verdict}, RBE {rbe}, {proof}: {count:,}")
    print(
        f"mechanisms of RBE that prove it: {tally.proofs[True]:,}, do not: {tally.proofs[False]:,}"
    )
    for number, wrong in tally.failures[:20]:
        print(f"FAILED {number}: {wrong}")
    print(f"{len(tally.failures)} failures")
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
