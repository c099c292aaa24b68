"""Files that a library of another language reads: in a separate program, with bounded time."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from drystone.base.errors import FormatError

_RUNNER = Path(__file__).with_name("extract.py")
_CPU_SHARE = 0.75
"""Of the elapsed time, processor time that may be used."""
_WALL_S_PER_MIB = 60.0
"""[s] A large file has more time, also for busy machines. Chosen."""


def content_of(
    data: bytes, path: Path, program: Path, options: Mapping[str, Any], wall_s: float
) -> bytes:
    """What the function ``content`` of a program makes of a file.

    Parameters
    ----------
    data, path
    program
        A Python file that needs nothing of drystone.
    options
        For the function, as JSON.
    wall_s
        [s] for a file of less than 1 MiB.

    Raises
    ------
    FormatError
        It crashed, or took too long.
    """
    patience = wall_s + _WALL_S_PER_MIB * (len(data) // 2**20)
    cpu_s = str(max(1, int(_CPU_SHARE * patience)))
    try:
        done = subprocess.run(
            [sys.executable, "-P", str(_RUNNER), str(program), cpu_s, json.dumps(options)],
            input=data,
            capture_output=True,
            timeout=patience,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise FormatError(
            f"was not read within {patience:g} s: it is damaged, or the machine is very busy",
            where=str(path),
            remedy="try again; if that does not help, save it again",
        ) from error
    if done.returncode != 0:
        raise FormatError(
            "is damaged: what reads it broke off", where=str(path), remedy="save it again"
        )
    return done.stdout
