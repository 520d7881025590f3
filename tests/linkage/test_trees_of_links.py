"""URDF and SDF of linkages without loops, and of those whose joints follow the drive; `linkframe convert`."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import ConversionWarning, Linkage, Motion, read_linkage, write_linkage
from linkframe.models.command_line import main
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

FOUR_BAR = Path(__file__).parents[2] / "examples" / "four_bar.toml"


def tree() -> Linkage:
    """A chain with joints of every kind, driven but for one, from either link."""
    made = Linkage(A=(0, 0, 0), B=(1, 0, 0.2), C=(2, 0.3, 0), D=(2.5, 1, 0.1), E=(3, 1, 1), F=(3.5, 1, 1), G=(4, 0, 1))
    for link in ("AB", "BC", "CD", "DE", "EF", "FG"):
        made.link(link, *link, mass=2.0, centre=made.points[link[1]], inertia=(1.0, 2.0, 2.5, 0.1, 0.2, 0.3))
    made.cylindrical("A", "ground", "AB", axis=(0, 1, 1), drive=True, reference=(0.1, 0.2))
    made.universal("B", "BC", "AB", axis=(0, 0, 1), second=(1, 1, 0), drive=True)
    made.planar("C", "CD", "BC", axis=(1, 1, 1), drive=True)
    made.screw("D", "CD", "DE", axis=(0, 1, 0), pitch=0.2, drive=True, reference=0.4)
    made.spherical("E", "DE", "EF", drive=True)
    made.fixed("F", "EF", "FG")
    return made


def parallelogram() -> Linkage:
    made = Linkage(A=(0, 0), B=(0.2, 1), C=(2.2, 1), D=(2, 0), P=(1, 1.5))
    made.link("AB", "A", "B", mass=1.0, inertia=0.1)
    made.link("BC", "B", "P", "C")
    made.link("CD", "C", "D", mass=2.0)
    made.revolute("A", "ground", "AB", drive=True, reference=0.5)
    made.revolute("B", "AB", "BC")
    made.revolute("C", "BC", "CD")
    made.revolute("D", "CD", "ground")
    return made


def wedges() -> Linkage:
    """A table that slides, and on it a wedge that is pushed up a slope."""
    made = Linkage(A=(0, 0), B=(1, 0), C=(1, 1))
    made.link("table", "A", "B")
    made.link("wedge", "B", "C")
    made.prismatic("A", "ground", "table", axis=(1, 0), drive=True)
    made.prismatic("B", "table", "wedge", axis=(0, 1))
    made.prismatic("C", "ground", "wedge", axis=(1, 2))
    return made


Frames = dict[str, Any]


def placed(file: Path, values: dict[str, float]) -> Frames:
    """Poses (4, 4) of links and points in a URDF or SDF file, by a reader of few lines: each child from its parent."""
    root = ElementTree.parse(file).getroot()
    is_urdf = root.tag == "robot"
    model = root if is_urdf else root.find("world/model")
    assert model is not None
    poses = {link.get("name"): floats(link.findtext("pose"))[:3] for link in model.findall("link")}
    poses["world"] = np.zeros(3)
    frames: Frames = {"ground" if is_urdf else "world": np.eye(4)}
    for joint in model.findall("joint"):
        parent, child, offset = (of_urdf if is_urdf else of_sdf)(joint, poses)
        name, kind, axis = joint.get("name", ""), joint.get("type"), direction(joint)
        mimic = joint.find(".//mimic")
        value = values.get(name, 0.0)
        if mimic is not None:
            factor = mimic.get("multiplier") or mimic.findtext("multiplier")
            value = float(factor or "nan") * values[mimic.get("joint", "")]
        moved = np.eye(4)
        moved[:3, 3] = offset + (value * axis if kind == "prismatic" else 0.0)
        if kind == "continuous":
            moved[:3, :3] = Rotation.from_rotvec(value * axis).as_matrix()
        elif kind == "ball":
            moved[:3, :3] = Rotation.from_rotvec(value).as_matrix()
        frames[child] = frames[parent] @ moved
    for frame in model.findall("frame"):
        at = np.eye(4)
        at[:3, 3] = floats(frame.findtext("pose"))[:3]
        frames[frame.get("name", "")] = frames[frame.get("attached_to", "")] @ at
    return frames


def of_urdf(joint: Any, poses: Any) -> tuple[str, str, Any]:
    assert floats(joint.find("origin").get("rpy")).tolist() == [0.0, 0.0, 0.0]
    return joint.find("parent").get("link"), joint.find("child").get("link"), floats(joint.find("origin").get("xyz"))


def of_sdf(joint: Any, poses: Any) -> tuple[str, str, Any]:
    parent, child = joint.findtext("parent"), joint.findtext("child")
    return parent, child, poses[child] - poses[parent]


def direction(joint: Any) -> Any:
    axis = joint.find("axis")
    return np.zeros(3) if axis is None else floats(axis.get("xyz") or axis.findtext("xyz"))


def floats(text: str | None) -> Any:
    return np.array([float(part) for part in (text or "0 0 0").split()])


def values_of(motion: Motion, pose: int, *, balls: bool) -> dict[str, Any]:
    """Coordinates from the reference configuration on, by the names that the files have."""
    out: dict[str, Any] = {}
    for name, pair in motion.linkage.joints.items():
        own = motion.coordinate(name)[pose] - pair.reference
        if pair.kind.name == "spherical":
            turned = motion.axes(pair.first)[pose].T @ motion.axes(pair.second)[pose]
            angles = Rotation.from_matrix(turned).as_euler("XYZ")
            hinges = {f"{name} r{letter}": angle for letter, angle in zip("xyz", angles, strict=True)}
            out |= {name: Rotation.from_matrix(turned).as_rotvec()} if balls else hinges
            continue
        out |= {f"{name} {each}": value for each, value in zip(pair.kind.coordinates, own, strict=True)}
        out |= {name: own[0]} if len(own) == 1 else {}
    return out


def check_places(linkage: Linkage, motion: Motion, file: Path) -> None:
    for pose in range(len(motion.position(next(iter(linkage.points))))):
        frames = placed(file, values_of(motion, pose, balls=file.suffix == ".sdf"))
        for link, own in linkage.links.items():
            for point in own.points:
                place = frames[f"{point} on {link}"][:3, 3]
                assert_allclose(place, motion.position(point, link)[pose], rtol=0.0, atol=1e-13)


def written(linkage: Linkage, file: Path) -> Path:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConversionWarning)
        write_linkage(linkage, file)
    return file


@pytest.mark.parametrize("ending", ["urdf", "sdf"])
def test_every_kind(ending: str, tmp_path: Path) -> None:
    linkage, t = tree(), np.linspace(0.0, 1.0, 5)[:, None]
    drives = {"A": [0.1, 0.2] + t * [1, 2], "B": t * [1, -1], "C": t * [1, 1, 2], "D": 0.4 + t[:, 0]}
    motion = linkage.move(drives | {"E": t * [1.0, 0.5, -0.7]})
    check_places(linkage, motion, written(linkage, tmp_path / f"tree.{ending}"))


@pytest.mark.parametrize("ending", ["urdf", "sdf"])
@pytest.mark.parametrize("make", [parallelogram, wedges])
def test_loops_that_follow(make: Any, ending: str, tmp_path: Path) -> None:
    """Only the drive is given; ``mimic`` does the rest."""
    linkage = make()
    motion = linkage.move(A=np.linspace(0.5, 2.0, 5))
    file = written(linkage, tmp_path / f"loop.{ending}")
    check_places(linkage, motion, file)
    followed = [
        joint for joint in ElementTree.parse(file).getroot().iter("joint") if joint.find(".//mimic") is not None
    ]
    assert len(followed) == {"parallelogram": 2, "wedges": 1}[make.__name__]


def test_sdf_of_readers_that_know_no_mimic(tmp_path: Path) -> None:
    """A version is written that readers know which are older than ``mimic``, where nothing follows."""
    arm = Linkage(A=(0, 0), B=(1, 0))
    arm.link("arm", "A", "B")
    arm.revolute("A", "ground", "arm", drive=True)
    version = {
        name: ElementTree.parse(written(linkage, tmp_path / f"{name}.sdf")).getroot().get("version")
        for name, linkage in {"arm": arm, "parallelogram": parallelogram()}.items()
    }
    assert version == {"arm": "1.7", "parallelogram": "1.11"}


@pytest.mark.parametrize("name", ["left::arm", "__arm__", "world"])
def test_names_that_sdf_keeps(name: str, tmp_path: Path) -> None:
    arm = Linkage(A=(0, 0), B=(1, 0))
    arm.link("arm", "A", "B")
    arm.revolute("A", "ground", "arm", drive=True, name=name)
    with pytest.raises(FrameError, match=rf"SDF keeps the name '{name}' for itself"):
        write_linkage(arm, tmp_path / "arm.sdf")


def test_masses(tmp_path: Path) -> None:
    linkage = tree()
    root = ElementTree.parse(written(linkage, tmp_path / "tree.urdf")).getroot()
    link = next(link for link in root.findall("link") if link.get("name") == "BC")
    own = {key: link.find(f"inertial/{key}").attrib for key in ("mass", "origin", "inertia")}  # type: ignore
    assert own["mass"] == {"value": "2"}
    assert own["inertia"] == {"ixx": "1", "iyy": "2", "izz": "2.5", "ixy": "0.1", "iyz": "0.2", "ixz": "0.3"}


def test_by_another_reader(tmp_path: Path) -> None:
    """yourdfpy reads the same places."""
    reader = pytest.importorskip("yourdfpy")
    linkage = parallelogram()
    motion = linkage.move(A=np.linspace(0.5, 2.0, 5))
    robot = reader.URDF.load(str(written(linkage, tmp_path / "loop.urdf")), load_meshes=False)
    assert robot.actuated_joint_names == ["A"]
    for pose in range(5):
        robot.update_cfg({"A": motion.coordinate("A")[pose, 0] - 0.5})
        place = robot.get_transform("P on BC", "ground")[:3, 3]
        assert_allclose(place, motion.position("P")[pose], rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("ending", ["urdf", "sdf"])
def test_loops_that_do_not_follow(ending: str, tmp_path: Path) -> None:
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(3, 2), D=(2, 0))
    for link in ("AB", "BC", "CD"):
        linkage.link(link, *link)
    linkage.revolute("A", "ground", "AB")
    for joint, first, second in (("B", "AB", "BC"), ("C", "BC", "CD"), ("D", "CD", "ground")):
        linkage.revolute(joint, first, second)
    with pytest.raises(FrameError, match=r"no closed loops, and joint C closes one: write MJCF"):
        write_linkage(linkage, tmp_path / f"x.{ending}")
    linkage.drive("A")
    with pytest.raises(FrameError, match=r"joint 'D' does not follow the drive in proportion .*: write MJCF"):
        write_linkage(linkage, tmp_path / f"x.{ending}")
    assert not list(tmp_path.iterdir())


def test_what_no_file_has(tmp_path: Path) -> None:
    batch = Linkage(A=(0, 0), B=np.ones((3, 2)))
    batch.link("arm", "A", "B")
    with pytest.raises(FrameError, match=r"carries a batch of shape \(3,\)"):
        write_linkage(batch, tmp_path / "x.xml")
    heavy = Linkage(A=(0, 0), B=(1, 0))
    heavy.link("arm", "A", "B", mass=np.ones(3))
    heavy.revolute("A", "ground", "arm")
    with pytest.raises(FrameError, match="mass of link 'arm' carries a batch"):
        write_linkage(heavy, tmp_path / "x.xml")
    world = Linkage(A=(0, 0), B=(1, 0))
    world.link("world", "A", "B")
    world.revolute("A", "ground", "world")
    with pytest.raises(FrameError, match="link 'world': in MJCF and SDF that is the ground"):
        write_linkage(world, tmp_path / "x.xml")


@pytest.mark.parametrize("ending", ["xml", "urdf", "sdf"])
def test_names_that_stand_twice(ending: str, tmp_path: Path) -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(2, 0))
    linkage.link("one", "A", "B")
    linkage.link("two", "B", "C")
    linkage.revolute("A", "ground", "one", name="B rz")
    linkage.cylindrical("B", "one", "two")
    with pytest.raises(FrameError, match=r"two .*joints.* would be called 'B rz': rename the link, joint or point"):
        write_linkage(linkage, tmp_path / f"x.{ending}")


def test_long_chains(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Links one on another as many as MuJoCo reads; of more the number is told."""
    monkeypatch.setattr("linkframe.models.linkage.robot_files.mjcf_write.DEEPEST", 3)
    chain = Linkage({f"P{k}": (k, 0.0) for k in range(5)})
    for k in range(4):
        chain.link(f"link {k}", f"P{k}", f"P{k + 1}")
        chain.revolute(f"P{k}", f"link {k - 1}" if k else "ground", f"link {k}")
    with pytest.raises(FrameError, match="more than 3 links hang one on another"):
        write_linkage(chain, tmp_path / "x.xml")


def test_inertia_of_no_body(tmp_path: Path) -> None:
    """More about one axis than about both others together: told, and raised about these; about z alone, a plate."""
    for inertia, told in (((1.0, 1.0, 3.0, 0, 0, 0), 1), ((1.0, 1.0, 2.0, 0, 0, 0), 0), (2.0, 0)):
        linkage = Linkage(A=(0, 0), B=(1, 0))
        linkage.link("arm", "A", "B", mass=1.0, inertia=inertia)
        linkage.revolute("A", "ground", "arm")
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always", ConversionWarning)
            write_linkage(linkage, tmp_path / "x.xml")
        assert len(found) == told
        again = read_linkage(tmp_path / "x.xml").links["arm"].inertia
        assert_allclose(again, np.diag([1.5, 1.5, 3.0] if told else [1.0, 1.0, 2.0]), rtol=1e-11)


def test_lengths(tmp_path: Path) -> None:
    """Links drawn roughly and given their true lengths are written as they are assembled."""
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(3, 2), D=(2, 0))
    for link, length in {"AB": 1.02, "BC": 3.1, "CD": 2.2}.items():
        linkage.link(link, *link, length=length)
    for joint, first, second in (("A", "ground", "AB"), ("B", "AB", "BC"), ("C", "BC", "CD"), ("D", "CD", "ground")):
        linkage.revolute(joint, first, second, drive=joint == "A")
    again = read_linkage(written(linkage, tmp_path / "x.xml"))
    turns = np.linspace(0.0, 1.0, 5)
    for point in "BC":
        expected = linkage.move(A=turns).position(point)
        assert_allclose(again.move(A=turns).position(point), expected, rtol=0.0, atol=1e-14)


def test_convert(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """TOML to MJCF and back, and what is left out is told."""
    there, back = tmp_path / "a.xml", tmp_path / "b.toml"
    assert main(["convert", str(FOUR_BAR), str(there)]) == 0
    told = capsys.readouterr().out
    assert "the clearance of joint B, D, E: left out" in told
    assert "has for linkframe run is left out: run, tolerances" in told
    assert main(["convert", str(there), str(back)]) == 0
    assert capsys.readouterr().out == f"Written: {back}\n"
    turns = np.linspace(1.0, 6.0, 5)
    for point in "BPD":
        expected = read_linkage(FOUR_BAR).move(A=turns).position(point)
        assert_allclose(read_linkage(back).move(A=turns).position(point), expected, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("a.toml", "b.step"), "choose an ending of .toml, .xml, .urdf, .sdf"),
        (("a.toml", "a.toml"), "would be written over itself"),
        (("none.toml", "b.xml"), "cannot be read"),
    ],
)
def test_convert_refuses(
    names: tuple[str, str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.toml").write_text(FOUR_BAR.read_text(encoding="utf-8"), encoding="utf-8")
    assert main(["convert", *(str(tmp_path / name) for name in names)]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("ending", [".toml", ".xml", ".urdf", ".SDF"])
def test_save_writes_what_describes_a_linkage_as_its_ending_says(tmp_path: Path, ending: str) -> None:
    made = tree()
    made.save(tmp_path / f"saved{ending}")
    write_linkage(made, tmp_path / f"written{ending}")
    saved, written = ((tmp_path / f"{name}{ending}").read_text("utf-8") for name in ("saved", "written"))
    assert saved.replace("saved", "written") == written


def test_save_tells_at_its_call_what_it_leaves_out(tmp_path: Path) -> None:
    made = tree()
    made.load("G", fx=1.0)
    with pytest.warns(ConversionWarning, match=r"saved\.urdf: URDF has no words for the loads") as told:
        made.save(tmp_path / "saved.urdf")
    assert told[0].filename == __file__
    with pytest.raises(FrameError, match=r"saved\.step does not tell by its ending how to save a linkage"):
        made.save(tmp_path / "saved.step")
