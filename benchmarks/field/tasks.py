"""What a solver of the benchmark is asked, and how it answers.

A task is one line of JSON on standard input: ``blocks`` (``vertices``, ``faces``, ``density``),
``fixed`` (positions), ``friction``, and ``interfaces`` (``a``, ``b``, ``points``, ``frame``,
``area``), which a solver may use or not. The model is turned so that gravity points along -z; ``g``
is its size. The answer is one line on standard output: ``stands`` (true, false, or null for no
answer), ``said`` and ``seconds`` of CPU. The first line, before any task, is the ``name``.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys


def answer_all(name, solve):
    """Answer tasks until there are no more; what ``solve`` prints is thrown away.

    Parameters
    ----------
    name
        Of the program, with its version.
    solve
        From a task to whether it stands, what it says, and seconds of CPU.
    """
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    with open(os.devnull, "w") as nothing:  # noqa: PTH123  # a device
        os.dup2(nothing.fileno(), 1)
    print(json.dumps({"name": name}), file=out, flush=True)
    for line in sys.stdin:
        try:
            with contextlib.redirect_stdout(sys.stderr):
                stands, said, seconds = solve(json.loads(line))
        except Exception as error:  # a solver that fails has no answer
            stands, said, seconds = None, f"{type(error).__name__}: {error}", None
        told = {"stands": stands, "said": str(said)[:200], "seconds": seconds}
        print(json.dumps(told), file=out, flush=True)


def model_of(task):
    """The model of a task for solvers that are built on drystone."""
    import numpy as np

    from drystone import Assembly, Block, Model

    blocks = tuple(
        Block(np.array(one["vertices"]), one["faces"], f"block-{i}", one["density"])
        for i, one in enumerate(task["blocks"])
    )
    fixed = np.isin(np.arange(len(blocks)), task["fixed"])
    load = (0.0, 0.0, -task["g"])
    return Model.of(Assembly(blocks, fixed), friction=task["friction"], load=load)
