"""What all tests share: hypothesis draws the same examples on every machine, and no deadline on a busy one.

No test leaves machine code in the user's folder, nor takes it from there. Each process calculates in one thread, as
several side by side would wait for each other.
"""

from __future__ import annotations

import os

# before NumPy is loaded, which reads them
for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

from hypothesis import settings  # noqa: E402

os.environ["LINKFRAME_CACHE"] = "off"
settings.register_profile("linkframe", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("linkframe")
