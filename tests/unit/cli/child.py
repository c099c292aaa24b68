"""What a child does that a test interrupts; it loads the program and nothing of the tests."""

import functools
import os
import signal
import sys
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

from drystone.cli import main


def program(code: str, arguments: tuple[str, ...], out: str, told: Connection) -> None:
    """The program in a child, with a part replaced."""
    with Path(out).open("wb") as file:
        os.dup2(file.fileno(), 1)
    os.dup2(told.fileno(), 2)
    for one in (signal.SIGTERM, signal.SIGHUP):  # nohup has them ignored
        signal.signal(one, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # in the background it is ignored

    def tell(words: str) -> None:
        os.write(2, f"{words}\n".encode())

    def wait(stop: Callable[[], bool] = lambda: False) -> None:
        end = time.monotonic() + 60.0
        while not stop() and time.monotonic() < end:
            time.sleep(0.01)

    exec(code, {"tell": tell, "wait": wait, "signal": signal, "functools": functools})
    sys.exit(main(arguments))
