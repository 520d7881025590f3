"""Where a linkage really goes: rigid motion, compliance, joint clearance, and their spread under tolerances.

There are three packages, each usable by itself:

``linkframe.framework``
    Frames of members and joints: description, solution, error bounds, modes, buckling, ParaView files.
``linkframe.elements``
    Parts of frames: beams with their sections and materials, joints, springs, point masses.
``linkframe.models``
    Linkages and the four-bar on top of frames, and the propagation of tolerances.

Every public name of the three can be imported from here, such as ``Frame``, ``Beam``, ``Linkage`` and ``FourBar``; its
package is loaded when the name is first used. ``dir(linkframe)`` lists them all, and ``help(linkframe.Frame)``
describes one. On the command line: ``linkframe --help``, or ``python -m linkframe --help``.

Examples
--------
>>> from linkframe import Beam, Frame, Material, Rectangle
>>> frame = Frame()
>>> frame.node("A", (0.0, 0.0, 0.0))
>>> frame.node("B", (1.0, 0.0, 0.0))
>>> frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
>>> frame.fix("A")
>>> frame.load("B", fy=-10.0)
>>> frame.solve().displacement("B")[:3]
array([ 0.    , -0.0025,  0.    ])
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkframe.elements import *  # noqa: F403
    from linkframe.framework import *  # noqa: F403
    from linkframe.models import *  # noqa: F403


def _packages() -> Iterator[object]:
    """The three packages, in the order of the time they take to load."""
    for name in ("framework", "elements", "models"):
        yield import_module(f"linkframe.{name}")


if not TYPE_CHECKING:  # hidden from type checkers, which then report names that do not exist

    def __getattr__(name: str) -> object:
        if name == "__version__":
            from importlib.metadata import version

            return version("linkframe")
        if name == "__all__":
            return [each for package in _packages() for each in package.__all__]
        if not name.startswith("_"):
            for package in _packages():
                if name in package.__all__:  # type: ignore[attr-defined]
                    return getattr(package, name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({"__version__", *globals()}.union(*(package.__all__ for package in _packages())))  # type: ignore[attr-defined]
