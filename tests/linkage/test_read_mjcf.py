"""MJCF that others wrote, as linkages: where MuJoCo has them, with its masses; and what is refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import ConversionWarning, Linkage, read_linkage
from numpy.testing import assert_allclose

mujoco = pytest.importorskip("mujoco")

# Degrees, classes of defaults, orientations of all sorts, masses of geoms, several joints of one body.
ARM = """
<mujoco model="arm">
  <compiler eulerseq="XYz"/>
  <default>
    <joint axis="0 1 0"/>
    <geom density="500"/>
    <default class="light"><geom density="20"/><joint axis="1 0 0" ref="10"/></default>
  </default>
  <include file="rest.xml"/>
  <worldbody>
    <body name="column" pos="0.1 0.2 0.3" euler="10 20 30">
      <joint name="turn" pos="0.02 0 0.01"/>
      <geom type="box" size="0.1 0.05 0.2" pos="0 0 0.1" quat="1 0.2 0 0.1"/>
      <geom type="sphere" size="0.05" mass="0.3"/>
      <frame pos="0 0 0.3" axisangle="1 1 0 40">
        <body name="boom" childclass="light" xyaxes="0 1 0 -1 0 0.3">
          <joint name="lift" type="hinge"/>
          <joint name="twist" type="hinge" axis="1 1 0.5" pos="0.1 0 0"/>
          <joint name="reach" type="slide" axis="0 0 -2" ref="0.05"/>
          <geom type="capsule" fromto="0 0 0 0.5 0.1 0" size="0.03"/>
          <site name="tip" pos="0.6 0.1 0"/>
          <body name="hand" pos="0.6 0.1 0" zaxis="1 0 1">
            <joint name="wrist" type="ball" class="main"/>
            <geom type="ellipsoid" size="0.1 0.05 0.02"/>
            <geom type="cylinder" size="0.02 0.1" pos="0 0.1 0" euler="5 0 80" class="main"/>
            <site name="finger" pos="0 0.2 0"/>
            <body name="nail" pos="0 0.2 0"><inertial pos="0 0 0.01" mass="0.01" diaginertia="1e-5 2e-5 2.5e-5"
              euler="0 10 20"/><site name="end" pos="0 0 0.03"/></body>
          </body>
        </body>
      </frame>
    </body>
  </worldbody>
  <actuator>
    <motor joint="turn"/><position joint="lift" kp="10"/><velocity joint="twist"/><general joint="reach"/>
    <motor joint="wrist" gear="1 0 0"/>
  </actuator>
</mujoco>
"""
REST = '<mujoco><option gravity="0 -1 -9"/></mujoco>'


def linkage_of(text: str, folder: Path) -> Linkage:
    (folder / "file.xml").write_text(text)
    return read_linkage(folder / "file.xml")


def test_an_arm(tmp_path: Path) -> None:
    """An open chain at random coordinates: its points, its energy, and its weight."""
    (tmp_path / "rest.xml").write_text(REST)
    linkage = linkage_of(ARM, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "file.xml"))
    data, random = mujoco.MjData(model), np.random.default_rng(3)
    assert linkage.weight.tolist() == [0.0, -1.0, -9.0]
    assert {name: pair.kind.name for name, pair in linkage.joints.items()} == {
        "turn": "revolute", "lift": "revolute", "twist": "revolute", "reach": "prismatic", "wrist": "spherical",
        "finger": "fixed",
    }  # fmt: skip
    for _ in range(5):
        data.qpos[:4] = model.qpos0[:4] + random.uniform(-0.5, 0.5, 4)
        turned = random.uniform(-1.0, 1.0, 3)
        mujoco.mju_axisAngle2Quat(data.qpos[4:8], turned / np.linalg.norm(turned), np.linalg.norm(turned))
        data.qvel[:4] = random.uniform(-1.0, 1.0, 4)
        mujoco.mj_forward(model, data)
        # A ball of the file turns in the axes of its body; that of the linkage in the ground's, as it is read.
        axes = linkage_axes(model)
        values = dict(zip(("turn", "lift", "twist", "reach"), data.qpos[:4], strict=True)) | {"wrist": axes @ turned}
        rates = dict(zip(("turn", "lift", "twist", "reach"), data.qvel[:4], strict=True))
        motion = linkage.move(values, rates=rates)
        for name in ("tip", "finger", "end"):
            assert_allclose(motion.position(name), data.site(name).xpos, rtol=0.0, atol=1e-14)
        moved = np.zeros(model.nv)
        mujoco.mj_mulM(model, data, moved, data.qvel)
        assert_allclose(motion.kinetic_energy(), data.qvel @ moved / 2.0, rtol=1e-12)


def linkage_axes(model: Any) -> Any:
    """Axes of the hand in the position of the file."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data.body("hand").xmat.reshape(3, 3)


# A rod that floats between two cranks: a ball at one end, a hinge in two points at the other; a gear-less screw.
FLOATING = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="crank" pos="0 0 0"><joint name="A" axis="0 0 1"/><geom size="0.1"/><site name="B" pos="0 1 0"/></body>
    <body name="rod" pos="0 1 0"><freejoint/><geom size="0.1" pos="1 0.5 0"/><site name="P" pos="1 1 0"/></body>
    <body name="rocker" pos="2 0 0"><joint name="D" axis="0 0 1"/><geom size="0.1"/></body>
    <body name="nut" pos="3 0 0"><joint name="nut rz" axis="0 0 1"/><joint name="nut uz" type="slide" axis="0 0 1"/>
      <geom size="0.1"/></body>
  </worldbody>
  <equality>
    <connect name="C" body1="rod" body2="rocker" anchor="2 0.5 0"/>
    <connect body1="rod" body2="rocker" anchor="2 0.5 1"/>
    <connect site1="B" site2="B rod"/>
    <joint joint1="nut rz" joint2="nut uz" polycoef="0 20 0 0 0"/>
    <weld body1="rod" body2="crank" active="false"/>
  </equality>
  <tendon>
    <spatial stiffness="30" damping="2" springlength="0.4"><site site="B"/><site site="P"/></spatial>
    <spatial name="measure"><site site="B"/><site site="P"/></spatial>
  </tendon>
  <actuator><motor joint="A"/><motor joint="nut rz"/></actuator>
</mujoco>
""".replace('<site name="P"', '<site name="B rod"/><site name="P"')


def test_loops_of_others(tmp_path: Path) -> None:
    linkage = linkage_of(FLOATING, tmp_path)
    found = {name: (pair.kind.name, pair.first, pair.second) for name, pair in linkage.joints.items()}
    assert found == {
        "A": ("revolute", "ground", "crank"),
        "D": ("revolute", "ground", "rocker"),
        "nut": ("screw", "ground", "nut"),
        "C": ("revolute", "rod", "rocker"),
        "crank rod": ("spherical", "crank", "rod"),
    }
    assert_allclose(linkage.joint("nut").pitch, 2.0 * np.pi / 20.0, rtol=1e-15)
    assert linkage.drives == {"A": ("rz",), "nut": ("rz",)}
    assert linkage.weight.tolist() == [0.0, 0.0, -9.81]
    (spring,) = linkage.springs
    assert (spring.stiffness, spring.length, spring.damping) == (30.0, 0.4, 2.0)
    t = np.linspace(0.0, 0.4, 5)
    place = linkage.move(A=t).position("C", "rocker") - linkage.points["D"]
    assert_allclose(np.linalg.norm(place, axis=1), np.hypot(0.0, 1.5), rtol=1e-14)


def with_joint(**more: str) -> str:
    given = {"joint": '<joint name="a"/>', "geom": '<geom size="0.1"/>', "beside": "", "body": "", "world": ""} | more
    return (
        f'<mujoco>{given["beside"]}<worldbody>{given["world"]}<body name="one" pos="1 0 0" {given["body"]}>'
        f'{given["joint"]}{given["geom"]}<site name="s"/></body><body name="two"><joint name="b"/><geom size="1"/>'
        '<site name="t"/></body></worldbody></mujoco>'
    )


REFUSED = {
    "not XML": ("<mujoco", "this is not XML"),
    "not MJCF": ("<robot/>", "it begins with <robot>"),
    "replicate": (with_joint(world='<replicate count="3"/>'), "it has <replicate>.*mj_saveLastXML"),
    "mocap": (with_joint(body='mocap="true"'), "body 'one' is moved by motion capture"),
    "mesh": (with_joint(geom='<geom type="mesh" mesh="m"/>'), "geom of body 'one' is a mesh.*<inertial>"),
    "class": (with_joint(joint='<joint class="none"/>'), "is of class 'none'"),
    "axis": (with_joint(joint='<joint name="a" axis="0 0 0"/>'), "joint 'a': axis is '0 0 0': give a direction"),
    "number": (with_joint(joint='<joint name="a" axis="0 x 0"/>'), "joint 'a': axis is '0 x 0': give 3 numbers"),
    "free": (with_joint(joint='<joint name="a"/><freejoint/>'), "body 'one' has a free joint beside others"),
    "gear": (
        with_joint(beside='<equality><joint name="g" joint1="a" joint2="b"/></equality>'),
        "joint 'a' is tied to 'b': a linkage has no gears",
    ),
    "curve": (
        with_joint(beside='<equality><joint name="g" joint1="a" joint2="b" polycoef="0 1 2 0 0"/></equality>'),
        "joint 'g' ties joint 'a' other than in proportion",
    ),
    "tendon": (
        with_joint(beside='<equality><tendon name="g" tendon1="k"/></equality>'), "tendon 'g' ties what a linkage",
    ),
    "open": (
        with_joint(beside='<equality><connect name="g" site1="s" site2="t"/></equality>'),
        "connect 'g' is open by 1 in the position of the file",
    ),
    "weld": (
        with_joint(beside='<equality><weld name="g" body1="one" body2="two" relpose="0 0 0 1 0 0 0"/></equality>'),
        "weld 'g' is open by 1",
    ),
    "body": (
        with_joint(beside='<equality><connect name="g" body1="three" anchor="0 0 0"/></equality>'),
        "connect 'g' names body 'three', which is not there: choose one of ground, one, two",
    ),
    "site": (
        with_joint(beside='<tendon><spatial stiffness="1"><site site="s"/><site site="u"/></spatial></tendon>'),
        "<spatial> names site 'u', which is not there",
    ),
    "pulley": (
        with_joint(beside='<tendon><spatial name="p" stiffness="1"><site site="s"/></spatial></tendon>'),
        "spatial 'p' runs over more than two sites",
    ),
    "slack": (
        with_joint(
            beside='<tendon><spatial name="p" stiffness="1" springlength="1 2"><site site="s"/><site site="t"/>'
            "</spatial></tendon>"
        ),
        "spatial 'p' is slack from 1 to 2",
    ),
    "drive": (with_joint(beside='<actuator><motor joint="c"/></actuator>'), "acts on joint 'c', which is not there"),
    "unit": (with_joint(beside='<compiler angle="grad"/>'), "compiler: angle is 'grad': give degree or radian"),
    "turns": (with_joint(beside='<compiler eulerseq="xyw"/>'), "compiler: eulerseq is 'xyw': give three of"),
    "few turns": (with_joint(beside='<compiler eulerseq="xy"/>'), "compiler: eulerseq is 'xy': give three"),
    "too many": (with_joint(joint='<joint name="a" pos="1 0 0 9"/>'), "joint 'a': pos is '1 0 0 9': give 3 numbers"),
    "no class": (with_joint(beside="<default><default/></default>"), "a <default> within another has no class"),
    "class twice": (
        with_joint(beside='<default><default class="x"/><default class="x"/></default>'), "is of class 'x', as another",
    ),
    "no file": (with_joint(beside="<include/>"), "an <include> has no file: give one"),
    "file": (with_joint(beside='<include file="x.xml"/>'), "<include file='x.xml'> cannot be read: No such file"),
    "kind of geom": (with_joint(geom='<geom type="cone" size="1"/>'), "is of type 'cone': give one of sphere"),
    "few sizes": (with_joint(geom='<geom type="box" size="1"/>'), "size of a box is '1': give 3 sizes above zero"),
    "no size": (with_joint(geom='<geom type="box"/>'), "geom of body 'one' has no size: give numbers"),
    "below zero": (with_joint(geom='<geom size="-1"/>'), "size of a sphere is '-1': give a size above zero"),
    "zero": (with_joint(geom='<geom type="capsule" size="0.1 0"/>'), "size of a capsule is '0.1 0': give 2"),
    "no length": (
        with_joint(geom='<geom type="capsule" size="1" fromto="1 0 0 1 0 0"/>'), "is '1 0 0 1 0 0': give two points",
    ),
    "mass": (with_joint(geom='<geom size="1" mass="heavy"/>'), "geom of body 'one': mass is 'heavy': give 1 number"),
    "no mass": (
        with_joint(geom='<inertial pos="0 0 0" diaginertia="1 1 1"/>'), "inertial of body 'one' has no mass: give 1 n",
    ),
    "deep": (
        "<mujoco><worldbody>" + 2000 * "<body>" + 2000 * "</body>" + "</worldbody></mujoco>", "nest fewer bodies",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_refused(what: str, tmp_path: Path) -> None:
    """With the file, the element and the remedy."""
    text, message = REFUSED[what]
    with pytest.raises(FrameError, match=f"^{re.escape(str(tmp_path))}/file.xml: .*{message}"):
        linkage_of(text, tmp_path)


def test_what_is_left_out_is_told(tmp_path: Path) -> None:
    text = with_joint(joint='<joint name="a" damping="2"/>', beside='<actuator><adhesion body="one"/></actuator>')
    with pytest.warns(ConversionWarning, match="damping of joint a; the actuator <adhesion>: left out"):
        linkage = linkage_of(text, tmp_path)
    assert set(linkage.joints) == {"a", "b"}


def test_files_that_are_not_read(tmp_path: Path) -> None:
    for name, message in {"a.urdf": "mj_saveLastXML", "a.sdf": "SDF is not read", "none.xml": "No such file"}.items():
        with pytest.raises(FrameError, match=message):
            read_linkage(tmp_path / name)
