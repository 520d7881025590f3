"""Drawings for CAD, read back by ezdxf: layers by link, joints as circles by kind, a block for each pose, units."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from reference.linkages import limited_four_bar

ezdxf = pytest.importorskip("ezdxf")
STEEL = Material(E=2e11, nu=0.3)


def slider_crank() -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0.1, 0), C=(0.4, 0), P=(0.2, 0.1))
    linkage.link("crank", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), STEEL))
    linkage.link("rod", "B", "P", "C")
    linkage.link("Rod", "C")
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("C", "rod", "Rod")
    linkage.prismatic("C", "ground", "Rod", axis=(1, 0), name="slide")
    linkage.spring(("Rod", "C"), ("ground", "A"), stiffness=10.0, length=0.3)
    return linkage


def of_layer(layout: Any, layer: str, kind: str = "*") -> list[Any]:
    return list(layout.query(f'{kind}[layer=="{layer}"]'))


def test_the_reference_configuration(tmp_path: Path) -> None:
    slider_crank().save(tmp_path / "crank.dxf", unit="mm")
    read = ezdxf.readfile(tmp_path / "crank.dxf")
    assert read.header["$INSUNITS"] == 4
    assert not read.audit().errors
    layers = {layer.dxf.name for layer in read.layers}
    # Names of layers do not differ by case alone.
    assert {"crank", "rod", "Rod 2", "joints revolute", "joints prismatic", "drives", "points", "springs"} <= layers
    space = read.modelspace()
    (line,) = of_layer(space, "crank", "LINE")
    assert_allclose([line.dxf.start, line.dxf.end], [(0, 0, 0), (0.1, 0, 0)])
    (outline,) = of_layer(space, "crank", "POLYLINE")
    corners = np.array([vertex.dxf.location for vertex in outline.vertices])
    # The section's y is in the plane.
    assert_allclose((corners.min(axis=0), corners.max(axis=0)), [(0, -0.01, 0), (0.1, 0.01, 0)], atol=1e-15)
    centres = {tuple(np.round(circle.dxf.center, 12)) for circle in of_layer(space, "joints revolute", "CIRCLE")}
    assert centres == {(0, 0, 0), (0.1, 0, 0), (0.4, 0, 0)}
    assert len(of_layer(space, "joints prismatic", "CIRCLE")) == len(of_layer(space, "joints prismatic", "LINE")) == 1
    assert len(of_layer(space, "drives", "CIRCLE")) == 1
    assert {text.dxf.text for text in of_layer(space, "points", "TEXT")} == set("ABCP")
    assert len(of_layer(space, "points", "POINT")) == 4


def test_a_motion_has_a_block_for_each_pose(tmp_path: Path) -> None:
    motion = slider_crank().move(A=np.radians(np.arange(0.0, 360.0, 45.0)))
    motion.save(tmp_path / "motion.dxf")
    read = ezdxf.readfile(tmp_path / "motion.dxf")
    assert read.header["$INSUNITS"] == 6
    space, blocks = read.modelspace(), [block.name for block in read.blocks if block.name.startswith("pose")]
    assert blocks == [f"pose {k:03d}" for k in range(8)]
    assert [insert.dxf.layer for insert in space.query("INSERT")] == blocks
    for k, name in enumerate(blocks):
        (line,) = of_layer(read.blocks[name], "crank", "LINE")
        assert_allclose([line.dxf.start, line.dxf.end], [motion.position("A")[k], motion.position("B")[k]], atol=1e-15)
        points = [tuple(point.dxf.location) for point in of_layer(read.blocks[name], "points", "POINT")]
        assert any(np.allclose(point, motion.position("P")[k], rtol=0, atol=1e-15) for point in points)
    (path,) = of_layer(space, "path of P", "POLYLINE")
    assert_allclose([v.dxf.location for v in path.vertices], motion.position("P"), atol=1e-15)
    assert not of_layer(space, "path of A")
    assert sum(len(of_layer(read.blocks[name], "points", "TEXT")) for name in blocks) == 4


def test_a_linkage_in_space(tmp_path: Path) -> None:
    """A circle lies about its joint's axis, where it is in the drawing's own coordinates; a round bar ends in rings."""
    linkage = Linkage(A=(0, 0, 0.1), B=(0.3, 0.2, 0.5), C=(0.5, 0.2, 0.5))
    linkage.link("arm: upper/lower", "A", "B", "C", beams=[("A", "B")], beam=Beam(Circle(diameter=0.02), STEEL))
    axis = np.array([1.0, 2.0, -1.0]) / math.sqrt(6.0)
    linkage.revolute("A", "ground", "arm: upper/lower", axis=axis, drive=True)
    linkage.move(A=[0.0, 0.4]).save(tmp_path / "arm.dxf")
    read = ezdxf.readfile(tmp_path / "arm.dxf")
    pose = read.blocks["pose 001"]
    for circle in pose.query("CIRCLE"):
        assert_allclose(np.array(circle.dxf.extrusion), axis, atol=1e-12)
        assert_allclose(np.array(circle.ocs().to_wcs(circle.dxf.center)), (0, 0, 0.1), atol=1e-12)
    rings = [
        np.array([v.dxf.location for v in ring.vertices]) for ring in of_layer(pose, "arm_ upper_lower", "POLYLINE")
    ]
    ends = linkage.move(A=0.4)
    for name in "AB":
        middle = ends.position(name)
        assert any(np.allclose(np.linalg.norm(ring - middle, axis=1), 0.01, rtol=1e-9) for ring in rings)


def test_poses_that_are_not_assembled_are_left_out(tmp_path: Path) -> None:
    motion = limited_four_bar().move(A=np.linspace(0.0, 6.0, 13))
    there = np.flatnonzero(motion.is_assembled)
    assert 0 < len(there) < 13
    motion.save(tmp_path / "chain.dxf")
    read = ezdxf.readfile(tmp_path / "chain.dxf")
    assert [i.dxf.name for i in read.modelspace().query("INSERT")] == [f"pose {k:03d}" for k in there]
    assert len(of_layer(read.modelspace(), "path of C")) == 2


def test_what_is_refused(tmp_path: Path) -> None:
    linkage = slider_crank()
    with pytest.raises(FrameError, match=r"x\.svg does not tell by its ending"):
        linkage.save(tmp_path / "x.svg")
    with pytest.raises(FrameError, match="unit='parsec': a drawing knows in, ft, mm, cm, m"):
        linkage.save(tmp_path / "x.dxf", unit="parsec")
    with pytest.raises(FrameError, match="entry=1, but the linkage has 1"):
        linkage.save(tmp_path / "x.dxf", entry=1)
    with pytest.raises(FrameError, match="the linkage has no points"):
        Linkage().save(tmp_path / "x.dxf")
    motion = linkage.move(A=np.zeros((2, 2)))
    with pytest.raises(FrameError, match="holds one row of poses"):
        motion.save(tmp_path / "x.dxf")
    with pytest.raises(FrameError, match="a drawing, which has no times"):
        linkage.move(A=[0.0, 1.0]).save(tmp_path / "x.dxf", [0.0, 1.0])
    assert not list(tmp_path.iterdir())


def test_names_are_read_in_the_plane_of_the_drawing(tmp_path: Path) -> None:
    """Seen from -y, x goes right and z up: by the arbitrary axis algorithm of DXF the extrusion (0, -1, 0)."""
    linkage = Linkage(A=(0, 0, 0), B=(1, 0, 0.5))
    linkage.link("arm", "A", "B")
    linkage.revolute("A", "ground", "arm", axis=(0, 1, 0), drive=True)
    linkage.save(tmp_path / "arm.dxf")
    space = ezdxf.readfile(tmp_path / "arm.dxf").modelspace()
    for text in of_layer(space, "points", "TEXT"):
        assert_allclose(np.array(text.dxf.extrusion), (0, -1, 0), atol=1e-12)
        at = np.array(text.ocs().to_wcs(text.dxf.insert))
        beside = at - linkage.points[text.dxf.text]
        assert beside[1] == pytest.approx(0.0)
        assert (beside[[0, 2]] > 0.0).all()
