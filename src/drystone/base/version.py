"""The version of the package, and the commit that it was made from."""

from __future__ import annotations

import subprocess
from functools import cache
from importlib import import_module
from pathlib import Path

_PACKAGE = Path(__file__).parents[1]
RECORD = _PACKAGE / "_commit.txt"
"""Written into the package when it is built from a git checkout; see ``hatch_build.py``."""


def version() -> str:
    """The version of drystone."""
    return str(import_module("drystone").__version__)


@cache
def commit() -> str:
    """The short hash of the commit; empty where neither the package nor git can tell."""
    if RECORD.is_file():
        return RECORD.read_text(encoding="ascii").strip()
    checkout = _PACKAGE.parents[1]
    if not (checkout / ".git").exists():
        return ""
    try:
        said = subprocess.run(
            ["git", "-C", str(checkout), "rev-parse", "--short=10", "HEAD"],
            capture_output=True, check=True, text=True, timeout=5.0,
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return ""
    return said.stdout.strip()
