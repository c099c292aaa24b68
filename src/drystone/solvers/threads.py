"""One BLAS thread while an analysis runs.

The fronts of a factorisation are small matrices of some hundred rows. Threads that share them wait
for each other: a check takes 4 to 14 times longer with 8 threads than with one. More cores help
only when whole analyses run in parallel.
"""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import LibController, ThreadpoolController

_lock = threading.RLock()
"""Its own thread may take it again: since Python 3.14 an interruption may leave it taken."""
_inside = 0
_before: list[tuple[LibController, int]] = []


@functools.cache
def _pools() -> list[LibController]:
    """The BLAS libraries of this process, found once: the search takes some milliseconds.

    Each takes the memory for its own work now. One that finds none later ends the process.
    """
    import numpy as np
    from scipy.linalg.blas import dgemm  # loads its own BLAS

    some = np.ones((64, 64))
    dgemm(1.0, some @ some, some)
    return ThreadpoolController().select(user_api="blas").lib_controllers


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Use one BLAS thread inside; restore the number afterwards, also after an error.

    The number belongs to the process. With analyses in several Python threads, the first to begin
    sets it and the last to end restores it.
    """
    global _inside
    with _lock:
        if _inside == 0:
            _before[:] = [(pool, n) for pool in _pools() if (n := pool.num_threads) > 1]
            for pool, _ in _before:
                pool.set_num_threads(1)
        _inside += 1
    try:
        yield
    finally:
        with _lock:
            _inside -= 1
            if _inside == 0:
                for pool, count in _before:
                    pool.set_num_threads(count)


def _alone() -> None:
    """In a forked process no other thread is inside."""
    global _inside, _lock
    _inside, _lock = 0, threading.RLock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_alone)
