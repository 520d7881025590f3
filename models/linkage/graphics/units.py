"""Default units of the labels of figures, and default number of poses in them."""

from __future__ import annotations

# Units of length and force.
Units = tuple[str, str]
SI: Units = ("m", "N")
# Approximate number of other poses that are drawn faintly.
GHOSTS = 8
