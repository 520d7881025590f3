"""What all tests share: hypothesis draws the same examples on every machine, and no deadline on a busy one.

No test leaves machine code in the user's folder, nor takes it from there.
"""

from __future__ import annotations

import os

from hypothesis import settings

os.environ["LINKFRAME_CACHE"] = "off"
settings.register_profile("linkframe", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("linkframe")
