"""What all tests share: hypothesis draws the same examples on every machine, and no deadline on a busy one."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("linkframe", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("linkframe")
