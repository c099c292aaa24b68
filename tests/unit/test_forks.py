"""A process may be forked while its threads calculate, and is refused without their lock."""

import subprocess
import sys

import pytest

FORKS = """
import os, signal, threading
import numpy as np
import drystone
from drystone.models import arch

filled = np.zeros(200_000)

def check():
    while True:
        drystone.check(arch(0.15, 20), friction=0.9)

def fill():
    while True:
        np.add(filled, 1.0, out=filled)

drystone.check(arch(0.15, 20), friction=0.9)
for work in (check, check, fill):
    threading.Thread(target=work, daemon=True).start()
for _ in range(6):
    child = os.fork()
    if not child:
        signal.alarm(60)
        assert np.ptp(filled) == 0.0, "forked in the midst of a compiled function"
        found = drystone.check(arch(0.15, 20), friction=0.9)
        os._exit(found.verdict != "stable")
    assert os.waitpid(child, 0)[1] == 0
os._exit(0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there are no forks")
def test_a_child_of_a_process_whose_threads_check_is_answered() -> None:
    subprocess.run([sys.executable, "-W", "ignore", "-c", FORKS], check=True)


def test_python_without_the_interpreter_lock_is_refused_in_words() -> None:
    without = "import sys; sys._is_gil_enabled = lambda: False; import drystone"
    run = subprocess.run([sys.executable, "-c", without], capture_output=True, text=True)
    assert run.returncode == 1
    assert "ImportError: drystone shares" in run.stderr
    assert "-X gil=1" in run.stderr
