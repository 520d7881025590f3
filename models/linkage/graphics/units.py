"""What figures of a linkage are labelled with, and how many poses they show, where nothing is said."""

from __future__ import annotations

# Units of length and force.
Units = tuple[str, str]
SI: Units = ("m", "N")
# Other poses that are drawn faintly.
GHOSTS = 8
