"""Write a linkage to a file, in the format of the file's ending."""

from __future__ import annotations

from pathlib import Path

from ....framework.paraview.files import whole_or_nothing
from ..description.linkage_description import LinkageDescription
from ..robot_files import formats
from ..robot_files.left_out import tell
from .toml import written
from .write import tables

ROBOTS = (".xml", ".urdf", ".sdf")


def write_linkage(linkage: LinkageDescription, path: str | Path) -> None:
    """Write a linkage to a file: TOML, or by its ending MJCF (``.xml``), URDF (``.urdf``) or SDF (``.sdf``).

    `read_linkage` reads the same linkage from TOML, to the last bit. The other formats describe rigid bodies on ideal
    joints, for programs such as MuJoCo. Their joint coordinates are those of the linkage; in URDF and SDF they are
    counted from the reference configuration. In MJCF,

    - bodies have the masses and inertias of links, or of their beams, and the axes of the ground in the reference
      configuration, which is that of qpos0;
    - points are sites: ``B`` on the first link that has it, ``B on coupler`` on another;
    - a joint with several coordinates is several joints, ``C uz`` and ``C rz``; in a screw an equality couples them;
    - a joint that closes a loop is an equality: for a spherical joint one point that two bodies share, for a revolute
      joint two; for other kinds a part of the link, ``piston at slide``, with a share of its mass, is welded to it;
    - drives are position actuators, springs are tendons, and loads are actuators with a constant force.

    Links without mass get 10⁻¹⁰ of the total mass, or some small mass if no link has any. URDF and SDF have no loops: a
    linkage with loops can be written only if all joints move in proportion to the drives, as in a parallelogram; these
    are joints with ``mimic``.

    Parameters
    ----------
    linkage
        The linkage; in TOML with its whole batch.
    path
        The file; it is replaced, and its folder made if it is missing.

    Raises
    ------
    FrameError
        If the folder cannot be written, or the format cannot describe the linkage: TOML has no user-defined elements,
        the others no batch, URDF and SDF no loops.

    Warns
    -----
    ConversionWarning
        If something is left out, as are stiffness and clearance of joints in all formats but TOML.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from linkframe.models.linkage import Linkage, read_linkage
    >>> linkage = Linkage(A=(0, 0), B=(1, 2))
    >>> linkage.link("bar", "A", "B", mass=2.0)
    >>> linkage.revolute("A", "ground", "bar", drive=True)
    >>> with TemporaryDirectory() as folder:
    ...     for name in ("bar.toml", "bar.xml"):
    ...         write_linkage(linkage, Path(folder) / name)
    ...         print(read_linkage(Path(folder) / name).points["B"])
    [1. 2. 0.]
    [1. 2. 0.]
    """
    write(linkage, Path(path), 2)


def write(linkage: LinkageDescription, path: Path, depth: int) -> None:
    """See `write_linkage`; warnings point at the call `depth` levels above."""
    name, left = "", list[str]()
    if path.suffix.lower() in ROBOTS:
        text, name, left = formats.robot_text(linkage, path.suffix.lower(), path.stem)
    else:
        text = written(tables(linkage))
    with whole_or_nothing(path.parent) as stage:
        (stage / path.name).write_text(text, encoding="utf-8")
    tell(path, left, name, depth + 1)
