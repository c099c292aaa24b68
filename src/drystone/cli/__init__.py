"""The command line: the only part of drystone that prints."""

import os

for _threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    # Before numpy is imported. Matrices are many and small: on a busy machine of two cores the
    # built-in vault takes 6 s with threads that wait for each other and 1 s with one.
    os.environ.setdefault(_threads, "1")

from drystone.cli.application import main  # noqa: E402  # after the environment is set

__all__ = ["main"]
