"""Read a linkage from a file."""

from __future__ import annotations

from pathlib import Path

from ....framework.errors import FrameError
from ..linkage import Linkage
from ..robot_files import mjcf_read
from .read import linkage_of
from .source import Source

# Formats that are written but not read, and what to do instead.
ELSEWHERE = {
    ".urdf": "URDF is not read: load it with mujoco.MjModel.from_xml_path, write it out with mujoco.mj_saveLastXML "
    "as .xml, and read that",
    ".sdf": "SDF is not read: describe the linkage as MJCF (.xml) or TOML",
}


def read_linkage(path: str | Path) -> Linkage:
    """Read a linkage from a TOML file, or from an MJCF file (``.xml``) of MuJoCo.

    Points, links and joints are tables by name; links name their beams, and beams their sections and materials, ::

        [points]
        A = [0.0, 0.0]
        B = [0.05, 0.0866]

        [links.crank]
        points = ["A", "B"]
        beam = "bar"                    # or beams = [["A", "B", "bar"]]; mass, centre, inertia, length

        [joints.A]
        kind = "revolute"               # any kind of `Linkage`
        point = "A"
        links = ["ground", "crank"]
        drive = true                    # or ["rz"]; axis, second, pitch, stiffness, clearance, contact, reference

        [[springs]]
        between = [["crank", "B"], ["ground", "E"]]
        stiffness = 2e3
        length = 0.1                    # damping

        [[loads]]
        link = "crank"
        point = "B"                     # without a point a torque: mx, my, mz
        fy = 100.0                      # follower = true if it turns with the link

        [beams.bar]
        section = "flat"
        material = "steel"              # end, up, shear, segments, release

        [sections.flat]
        shape = "rectangle"             # circle, tube, i, properties
        y = 0.0127
        z = 0.00635

        [materials.steel]
        E = 2e11
        nu = 0.3                        # or G; density

    with ``gravity = [0.0, -9.81, 0.0]`` at the top, and ``drives = ["B", "A"]`` if their order is not that of the
    joints. Lengths, forces and masses are in any consistent units, angles in radians. ``inf`` is a number.

    ``linkframe run`` reads tolerances of these numbers from the same file, each a table of any name, ::

        [tolerances.clearance]
        of = ["joints.B.clearance"]     # entries that share one draw must all have the same number
        distribution = "norm"           # any continuous distribution of scipy.stats, with its parameters
        loc = 1e-4                      # near the number of the file, compared with the spread
        scale = 5e-6

        [tolerances.stiffness]
        of = ["joints.B.stiffness"]     # a list: every number in it but 0 and inf; one of them: joints.B.stiffness.ux
        distribution = "norm"
        scale = "5 %"                   # loc and scale in percent are deviations: number * (1 + draw), here ± 5 %

    Components are named or counted from 0: ``ux uy uz rx ry rz`` of a stiffness, ``x y z`` of a point or direction,
    ``xx yy zz xy yz zx`` of an inertia; entries of lists of tables have numbers, as in ``loads.0.fy``. No number may be
    in two tolerances.

    In MJCF, bodies become links with their masses, and sites become points. The joints of a body become one joint if
    there is such a kind, otherwise several with massless links between them. One point that two bodies share by
    ``connect`` becomes a spherical joint, several in line a revolute joint, and ``weld`` a fixed one. Joints with
    actuators are driven, tendons from site to site become springs. Contacts, limits, sensors and keyframes are not
    read. `write_linkage` writes such files.

    Parameters
    ----------
    path
        The file. Its tables ``run``, ``tolerances``, ``choices`` and ``measured`` belong to ``linkframe run``.

    Returns
    -------
    Linkage
        The linkage.

    Raises
    ------
    FrameError
        If the file cannot be read, or something in it is wrong or not possible in a linkage; the message names the line
        and the key, or the element.

    Warns
    -----
    ConversionWarning
        If an MJCF file has something that a linkage cannot describe, such as friction in joints; it is left out.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from linkframe.models import read_linkage
    >>> text = '''
    ... [points]
    ... A = [0.0, 0.0]
    ... B = [1.0, 0.0]
    ... [links.arm]
    ... points = ["A", "B"]
    ... [joints.A]
    ... kind = "revolute"
    ... point = "A"
    ... links = ["ground", "arm"]
    ... drive = true
    ... '''
    >>> with TemporaryDirectory() as folder:
    ...     _ = (Path(folder) / "arm.toml").write_text(text)
    ...     linkage = read_linkage(Path(folder) / "arm.toml")
    >>> linkage.drives
    {'A': ('rz',)}
    """
    ending = Path(path).suffix.lower()
    if ending in ELSEWHERE:
        raise FrameError(f"{path}: {ELSEWHERE[ending]}")
    if ending == ".xml":
        return mjcf_read.mjcf_linkage(Path(path), Linkage)
    return linkage_of(Source(path), Linkage)
