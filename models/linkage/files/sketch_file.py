"""A file to start from: a small linkage with everything that a run can use, explained by comments."""

from __future__ import annotations

from pathlib import Path

from ....framework.errors import FrameError
from ....framework.paraview.files import whole_or_nothing

SKETCH = """\
# A linkage for `linkframe run`: a crank that turns, a rocker that swings, and P on the coupler between them.
# Change it into yours. SI units; angles of drives in degrees where the file says so, else radians.
title = "My linkage"
# gravity = [0.0, -9.81, 0.0]     # weighs links whose material has a density

# -- the linkage, drawn in one position in which it is assembled -----------------------------------------------------

[points]                          # x, y, or x, y, z for a linkage in space
A = [0.0, 0.0]
B = [0.0, 0.1]
P = [0.12, 0.19]
D = [0.24, 0.16]
E = [0.22, 0.0]

[links.crank]
points = ["A", "B"]               # all points that lie on the link
beam = "bar"                      # runs from point to point; without it the link is rigid

[links.coupler]
points = ["B", "P", "D"]
beam = "bar"

[links.rocker]
points = ["D", "E"]
beam = "bar"

[joints.A]
kind = "revolute"                 # or prismatic, cylindrical, spherical, universal, planar, screw, fixed
point = "A"
links = ["ground", "crank"]       # the ground is a link, too
drive = true

[joints.B]
kind = "revolute"                 # its axis is z; another one: axis = [1.0, 0.0, 0.0]
point = "B"
links = ["crank", "coupler"]
stiffness = [2e8, 2e8, 2e8, 2e5, 2e5, 0.0]   # N/m along x y z, N m/rad about them; 0 is free, without it ideal

[joints.D]
kind = "revolute"
point = "D"
links = ["coupler", "rocker"]
stiffness = [2e8, 2e8, 2e8, 2e5, 2e5, 0.0]
clearance = 5e-5                  # of the radii, m

[joints.E]
kind = "revolute"
point = "E"
links = ["rocker", "ground"]

[[loads]]                         # one such table for each force
point = "P"
fy = -50.0                        # fx, fy, fz in N; mx, my, mz in N m

# -- what the links are made of --------------------------------------------------------------------------------------

[beams.bar]
section = "flat"
material = "steel"

[sections.flat]
shape = "rectangle"               # or circle (diameter), tube (outer, thickness), i (height, width, web, flange)
y = 0.0127                        # in the plane of motion, m
z = 0.00635                       # across it

[materials.steel]
E = 2e11                          # Pa
nu = 0.3
density = 7850.0                  # kg/m3

# -- what to compute -------------------------------------------------------------------------------------------------

[run]
points = ["P"]                    # whose displacement is reported
pose = 60.0                       # what the figures show, a value of the drive
samples = 200                     # with tolerances

[run.drives.A]                    # one such table for each drive
start = 0.0                       # from the position drawn above on
stop = 360.0
steps = 37
unit = "deg"
# rate = 36000.0                  # degrees a second: the links' inertia then acts

[tolerances.length]               # any name; delete these tables for a run without tolerances
of = ["points.B.y"]
distribution = "norm"             # of scipy.stats, with its numbers
loc = 0.1
scale = 2e-5

[tolerances.clearance]
of = ["joints.D.clearance"]
distribution = "uniform"
loc = 4e-5
scale = 2e-5
"""


def write_sketch(path: str | Path) -> None:
    """Write a commented file with a small linkage, to start one's own from.

    Parameters
    ----------
    path
        The file, ``.toml``; its folder is made if it is missing.

    Raises
    ------
    FrameError
        If the name does not end in ``.toml``, there is such a file already, or it cannot be written.
    """
    path = Path(path)
    if path.suffix != ".toml":
        raise FrameError(f"{path} does not end in .toml: name it {path.with_suffix('.toml').name}")
    if path.exists():
        raise FrameError(f"{path} is there already and is left as it is: choose another name, or remove it first")
    with whole_or_nothing(path.parent) as stage:
        (stage / path.name).write_text(SKETCH, encoding="utf-8")
