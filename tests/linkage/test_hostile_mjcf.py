"""MJCF that is unusual, or wrong: read where MuJoCo has it, or refused by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from linkage.test_read_mjcf import linkage_of
from linkframe.framework import FrameError
from linkframe.models import ConversionWarning
from numpy.testing import assert_allclose

mujoco = pytest.importorskip("mujoco")


def whole(inside: str = '<joint name="j"/>', *, beside: str = "", body: str = "", more: str = "") -> str:
    return (
        f'<mujoco>{beside}<worldbody><body name="b" pos="1 0 0" {body}><geom size="0.1"/>{inside}'
        f'<site name="s" pos="0.3 0.2 0.1"/></body>{more}</worldbody></mujoco>'
    )


TURNED = '<frame euler="10 20 30"><joint name="one" axis="1 0 0"/></frame>'
SECOND = '<joint name="two" axis="0 0.3 1" pos="0.1 0 0.2" ref="20"/>'
GEOM = '<geom size="0.2 0.1 0.1" group="5" type="box"/>'
READ = {
    "joints in frames": whole(TURNED + SECOND),
    "joints behind bodies": whole(f'<body name="c"><geom size="0.1"/><joint name="k"/></body>{SECOND}'),
    "line": whole('<joint name="j"/><site name="t" type="capsule" size="0.1" fromto="0 0 0 0.4 0.2 0"/>'),
    "own orientation": whole(
        '<joint name="j"/><frame euler="0 0 9"><site name="t" euler="0 40 0"/></frame>',
        beside='<default><site quat="1 1 0 0"/></default>',
    ),
    "groups": whole(f'<joint name="j"/>{GEOM}', beside='<compiler inertiagrouprange="0 4"/>'),
    "group of a class": whole(
        f'<joint name="j"/>{GEOM}',
        beside='<compiler inertiagrouprange="2 5"/><default><geom group="1"/></default>',
    ),
    "mass of no group": whole(
        '<joint name="j"/><inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/>',
        beside='<compiler inertiagrouprange="2 5" inertiafromgeom="true"/>',
    ),
    "nothing changed": whole(beside='<compiler settotalmass="-1" boundmass="0.0" balanceinertia="false"/>'),
}


@pytest.mark.parametrize("what", READ)
def test_read_as_mujoco_does(what: str, tmp_path: Path) -> None:
    linkage = linkage_of(READ[what], tmp_path)
    model = mujoco.MjModel.from_xml_string(READ[what])
    data = mujoco.MjData(model)
    names = [model.joint(number).name for number in range(model.njnt)]
    for name in names:
        linkage.drive(name)
    data.qpos += np.linspace(0.3, 0.5, model.nq)
    mujoco.mj_forward(model, data)
    motion = linkage.move(**dict(zip(names, data.qpos.tolist(), strict=True)))
    for number in range(model.nsite):
        place = motion.position(model.site(number).name, model.body(model.site_bodyid[number]).name)
        assert_allclose(place, data.site_xpos[number], rtol=0.0, atol=1e-14)
    for link in linkage.links.values():
        if link.name in ("b", "c"):
            mass = 0.0 if link.mass is None else link.mass
            assert_allclose(mass, model.body(link.name).mass[0], rtol=1e-14)


def test_orientation_of_a_line(tmp_path: Path) -> None:
    """Forces follow the axes of the site, of which z runs from the end to the start."""
    force = '<general site="t" gainprm="0" biastype="affine" biasprm="1" gear="0 0 2"/>'
    text = READ["line"].replace("<worldbody>", f"<actuator>{force}</actuator><worldbody>")
    (load,) = linkage_of(text, tmp_path).loads
    data = mujoco.MjData(mujoco.MjModel.from_xml_string(text))
    mujoco.mj_forward(data.model, data)
    assert_allclose(load.value[:3], 2.0 * data.site("t").xmat.reshape(3, 3)[:, 2], atol=1e-15)


def test_what_is_switched_off(tmp_path: Path) -> None:
    pair = '<body name="c"><geom size="0.1"/><joint name="k"/><site name="t"/></body>'
    ball = '<equality><connect body1="b" body2="c" anchor="0 0 0"/></equality>'
    for off in ('<option><flag equality="disable"/></option>', '<default><equality active="false"/></default>'):
        assert set(linkage_of(whole(beside=ball + off, more=pair), tmp_path).joints) == {"j", "k"}
    assert set(linkage_of(whole(beside=ball, more=pair), tmp_path).joints) == {"j", "k", "b c"}
    weightless = whole(beside='<option gravity="0 0 -5"><flag gravity="disable"/></option>')
    assert not linkage_of(weightless, tmp_path).weight.any()


def test_stiffness_of_all_tendons(tmp_path: Path) -> None:
    pair = '<body name="c"><geom size="0.1"/><joint name="k"/><site name="t"/></body>'
    spring = '<tendon><spatial><site site="s"/><site site="t"/></spatial></tendon>'
    text = whole(beside=f'<default><tendon stiffness="5"/></default>{spring}', more=pair)
    assert [found.stiffness for found in linkage_of(text, tmp_path).springs] == [5.0]


def test_what_is_left_out_is_told(tmp_path: Path) -> None:
    text = whole('<joint name="j" range="-10 10"/>', body='gravcomp="1"')
    with pytest.warns(ConversionWarning, match="gravcomp of body b; the range of joint j: left out"):
        linkage_of(text, tmp_path)


TWO = '<body name="c"><geom size="0.1"/><joint name="k"/></body>'
REFUSED = {
    "type": (whole('<joint name="j" type="Hinge"/>'), "joint 'j' is of type 'Hinge': give one of hinge, slide"),
    "total": (whole(beside='<compiler settotalmass="7"/>'), "compiler: settotalmass='7' changes the masses"),
    "least": (whole(beside='<compiler boundinertia="0.1"/>'), "compiler: boundinertia='0.1' changes the masses"),
    "balance": (whole(beside='<compiler balanceinertia="true"/>'), "compiler: balanceinertia='true' changes"),
    "global": (whole(beside='<compiler coordinate="global"/>'), "coordinate='global': write places relative to"),
    "shell": (whole('<geom size="1" shellinertia="true"/>'), "geom of body 'b' is a shell"),
    "outermost": (whole(beside='<default class="x"/>'), "outermost <default> is of class 'x': leave its class out"),
    "two sites": (whole('<site name="s"/>'), "site 's' is there twice"),
    "world": (whole(more=TWO.replace('"c"', '"world"')), "body 'world' is there twice, or is called as the ground"),
    "two orientations": (whole(body='quat="1 0 1 0" euler="0 0 9"'), "body 'b' has quat and euler: give one of them"),
    "quat": (whole(body='quat="0 0 0 0"'), "body 'b': quat is '0 0 0 0': give a direction"),
    "axis": (whole(body='axisangle="0 0 0 9"'), "body 'b': axisangle is '0 0 0 9': give a direction"),
    "axes": (whole(body='xyaxes="1 0 0 2 0 0"'), "body 'b': xyaxes is '1 0 0 2 0 0': give a direction"),
    "free": (whole('<joint name="j"/><body><freejoint name="f"/></body>'), "joint 'f' is free on body 'b'"),
    "line": (whole('<site name="t" fromto="0 0 0 1 0 0" pos="1 0 0"/>'), "site 't' has a place beside fromto"),
    "gear": (
        whole(beside='<equality><joint joint1="j" joint2="k" polycoef="0"/></equality>', more=TWO),
        "joint 'j' is tied to 'k': a linkage has no gears",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_refused(what: str, tmp_path: Path) -> None:
    text, message = REFUSED[what]
    with pytest.raises(FrameError, match=message):
        linkage_of(text, tmp_path)
