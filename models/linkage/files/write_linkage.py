"""A linkage to a file, in the format that its ending tells."""

from __future__ import annotations

from pathlib import Path

from ....framework.paraview.files import whole_or_nothing
from ..description.linkage_description import LinkageDescription
from ..robot_files.left_out import tell
from .toml import written
from .write import tables

ROBOTS = (".xml", ".urdf", ".sdf")


def write_linkage(linkage: LinkageDescription, path: str | Path) -> None:
    """Write a linkage to a file: TOML, or by its ending MJCF (``.xml``), URDF (``.urdf``) or SDF (``.sdf``).

    From TOML `read_linkage` makes the same again, to the last bit. The other formats have rigid bodies on ideal joints,
    for engines such as MuJoCo; their coordinates are those of the linkage, in MJCF counted as there, in URDF and SDF
    from the reference configuration. In MJCF,

    - bodies have the masses and inertias of links, or of their beams, and the axes of the ground in the reference
      configuration, in which qpos0 puts them;
    - points are sites: ``B`` on the first link that has it, ``B on coupler`` on another;
    - a joint with several coordinates is several, ``C uz`` and ``C rz``; a screw has an equality between them;
    - a joint that closes a loop is an equality: one point that two bodies share for a ball, two for a hinge, and for
      other kinds a part of the link, ``piston at slide``, with its share of the mass, which is welded to it;
    - drives are position actuators, springs tendons, and loads actuators with a constant force.

    Links without mass have 10⁻¹⁰ of all mass; where none has any, something that moves. URDF and SDF have no loops: a
    linkage with loops goes there only where all joints follow the drives in proportion, as in a parallelogram, by
    ``mimic``.

    Parameters
    ----------
    linkage
        What is written; in TOML all of its batch included.
    path
        The file; it is replaced, and its folder made where it is missing.

    Raises
    ------
    FrameError
        If the folder cannot be written, or the linkage has something for which the format has no words: in TOML
        elements of one's own, in the others a batch, in URDF and SDF loops.

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
    """See `write_linkage`; what is left out is told at the call so many levels above."""
    name, left = "", list[str]()
    if path.suffix.lower() in ROBOTS:
        from ..robot_files.formats import robot_text  # most linkages are not written there

        text, name, left = robot_text(linkage, path.suffix.lower(), path.stem)
    else:
        text = written(tables(linkage))
    with whole_or_nothing(path.parent) as stage:
        (stage / path.name).write_text(text, encoding="utf-8")
    tell(path, left, name, depth + 1)
