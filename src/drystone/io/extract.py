"""What a library reads in a file: run as a separate program, never imported.

A library in another language can hang or crash on a damaged file, or write to stdout. As a separate
process it cannot stop drystone. The program gets the path of a Python file with a function
``content``, seconds of processor time, and options as JSON; the file to read comes from stdin. To
stdout it writes what ``content(data, options)`` returns, as JSON where it is no bytes. It needs
nothing of drystone.
"""

import json
import os
import runpy
import sys

_MEMORY = 2 * 2**30
"""[bytes], chosen: enough for large models. It also stops files that announce a wrong size."""


def limit(cpu_s: int) -> None:
    """Bound processor time and memory where the system can."""
    try:
        import resource
    except ImportError:  # Windows: only the caller's timeout
        return
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 1))
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))


if __name__ == "__main__":
    limit(int(sys.argv[2]))
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print
    content = runpy.run_path(sys.argv[1])["content"]
    found = content(sys.stdin.buffer.read(), json.loads(sys.argv[3]))
    answer.write(found if isinstance(found, bytes) else json.dumps(found).encode())
    answer.close()
