"""What a solver of the benchmark is asked, and how it answers.

A task is one line of JSON on standard input: ``blocks`` (``vertices``, ``faces``, ``density``),
``fixed`` (positions), ``friction``, and ``interfaces`` (``a``, ``b``, ``points``, ``frame``,
``area``), which a solver may use or not. Joints that carry more than friction have ``tension``,
``cohesion`` and ``shear`` [N] too, for the whole interface, 1e30 for no limit. The model is turned
so that gravity points along -z; ``g`` is its size. ``limit`` is the largest CPU time in seconds.
The answer is one line on standard output: ``stands`` (true, false, or null for no answer), ``said``
and ``seconds`` of CPU. The first line, before any task, is the ``name``.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys


def answer_all(name, solve, dry_only=True):
    """Answer tasks until there are no more; what ``solve`` prints is thrown away.

    Parameters
    ----------
    name
        Of the program, with its version.
    solve
        From a task to whether it stands, what it says, and seconds of CPU.
    dry_only
        Whether it knows only joints without tension and cohesion: others have no answer.
    """
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    with open(os.devnull, "w") as nothing:  # noqa: PTH123  # a device
        os.dup2(nothing.fileno(), 1)
    print(json.dumps({"name": name}), file=out, flush=True)
    for line in sys.stdin:
        task = json.loads(line)
        _end_after(task["limit"])
        try:
            if dry_only and any("tension" in one for one in task["interfaces"]):
                raise NotImplementedError("joints that carry more than friction")
            with contextlib.redirect_stdout(sys.stderr):
                stands, said, seconds = solve(task)
        except Exception as error:  # a solver that fails has no answer
            stands, said, seconds = None, f"{type(error).__name__}: {error}", None
        told = {"stands": stands, "said": str(said)[:200], "seconds": seconds}
        print(json.dumps(told), file=out, flush=True)


def _end_after(seconds):
    """End this process when it has used so much more CPU; where the system can do that."""
    with contextlib.suppress(ImportError):
        import resource

        spent = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
        _, most = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(spent + seconds), most))


def model_of(task):
    """The model of a task for solvers that are built on drystone; it searches for the contacts.

    Joints that carry more than friction are those of the task.
    """
    import numpy as np

    from drystone import Assembly, Block, Model

    blocks = tuple(
        Block(np.array(one["vertices"]), one["faces"], f"block-{i}", one["density"])
        for i, one in enumerate(task["blocks"])
    )
    fixed = np.isin(np.arange(len(blocks)), task["fixed"])
    assembly, load = Assembly(blocks, fixed), (0.0, 0.0, -task["g"])
    if any("tension" in one for one in task["interfaces"]):
        return Model(assembly, _contacts(task), load)
    return Model.of(assembly, friction=task["friction"], load=load)


def _contacts(task):
    import numpy as np

    from drystone import Contacts, JointCapacity

    def of(key):
        return np.array([one[key] for one in task["interfaces"]])

    count = len(task["interfaces"])
    return Contacts(
        of("a"),
        of("b"),
        of("frame"),
        of("area"),
        np.full(count, task["friction"]),
        np.concatenate([one["points"] for one in task["interfaces"]]),
        np.repeat(np.arange(count), [len(one["points"]) for one in task["interfaces"]]),
        JointCapacity(of("tension"), of("cohesion"), of("shear"), brittle=False),
    )
