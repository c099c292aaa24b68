"""The command line: the only part of drystone that prints."""

import os
import sys
from collections.abc import Sequence
from contextlib import closing

from drystone.cli.waiting import UNDER_WAY, Waiting

for _threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    # Before numpy is imported. The matrices are many and small. On a busy machine of two cores the
    # built-in vault takes 6 s with threads that wait for each other and 1 s with one.
    os.environ.setdefault(_threads, "1")

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code; see :func:`drystone.cli.application.main`."""
    try:
        with closing(Waiting()):  # says what is done from here on
            try:
                from drystone.cli.application import main as run  # Ctrl-C may come meanwhile
            except KeyboardInterrupt:
                print("drystone: interrupted; nothing was written", file=sys.stderr)
                return 130
            return run(arguments)
    finally:
        UNDER_WAY.set(None)  # the next command of this process was not interrupted
