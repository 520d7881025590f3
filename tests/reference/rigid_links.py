"""Two rigid links with clearance in their pins, in which no offset fits where they lie in line."""

from __future__ import annotations

import numpy as np
from linkframe.elements import Joint
from linkframe.framework import Frame
from numpy.typing import ArrayLike


def rigid_links(height: ArrayLike, fx: ArrayLike, fy: ArrayLike) -> Frame:
    """Two rigid links from A to C, a unit wide each, on ideal pins with clearance, loaded at B, which is as high."""
    frame, y = Frame(), np.asarray(height)
    for name, x in {"A": 0.0, "B": 1.0, "C": 2.0}.items():
        for end in ("", "'"):
            frame.node(name + end, np.stack(np.broadcast_arrays(x, y if name == "B" else 0.0, 0.0), axis=-1))
        pin = Joint((np.inf,) * 5 + (0.0,), clearance=1e-4, clearance_directions=("ux", "uy"))
        frame.add(f"pin {name}", pin, name, name + "'")
    frame.rigid("A'", "B")
    frame.rigid("B'", "C")
    frame.fix("A")
    frame.fix("C'")
    frame.load("B", fx=fx, fy=fy)
    return frame
