"""What all tests share; read before any of them imports numpy."""

import os

# The tests run side by side: threads of linear algebra would only wait for each other.
for threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
