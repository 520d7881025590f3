"""Sections from the package sectionproperties against closed forms and the library's own shapes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, CrossSection, ISection, Material, Rectangle, Section, Tube
from linkframe.framework import Frame, FrameError
from linkframe.models import Linkage, read_linkage, write_linkage
from numpy.testing import assert_allclose

FORCES = np.array(
    [[1e3, 0, 0, 0, 40.0, -25.0], [0, 2e3, 1e3, 0, 0, 0], [0, 0, 0, 30.0, 0, 0], [1e3, 5e2, 2e3, 9, 50, 30]]
)


def analysed(name: str, mesh: float, **sizes: float) -> Any:
    library = pytest.importorskip("sectionproperties.pre.library")
    return getattr(library, name)(**sizes).create_mesh([mesh])


SHAPES = {
    "rectangle": (Rectangle(y=0.01, z=0.02), "rectangular_section", 1.0, {"b": 10, "d": 20}),
    "tube": (Tube(outer=0.04, thickness=0.001), "circular_hollow_section", 0.5, {"d": 40, "t": 1, "n": 128}),
    "I": (
        ISection(height=0.1, width=0.06, web=0.005, flange=0.008),
        "i_section",
        4.0,
        {"d": 100, "b": 60, "t_f": 8, "t_w": 5, "r": 0, "n_r": 1},
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_against_own_shapes(name: str) -> None:
    """Areas and second moments to the polygon's digits, torsion, shear and stress to those of the mesh and formulas."""
    own, shape, mesh, sizes = SHAPES[name]
    found = Section.from_sectionproperties(analysed(shape, mesh, **sizes), unit=1e-3)
    chords = 1e-3 if name == "tube" else 1e-10
    for each in ("A", "Iy", "Iz"):
        assert_allclose(getattr(found, each), getattr(own, each), rtol=chords)
    for each in ("J", "ky", "kz"):
        # The own I has the shear flow of thin walls along its middle lines, and 5/6 of the flanges' share along these.
        rough = {"ky": 0.03, "kz": 0.1}.get(each, 0.02) if name == "I" else 0.02
        assert_allclose(getattr(found, each), getattr(own, each), rtol=rough)
    ours = own.stress(FORCES)
    assert_allclose(found.stress(FORCES)[:, :2], ours[:, :2], rtol=2e-3, atol=1e-3 * np.abs(ours).max())
    if name != "I":  # whose corners have a concentration that Jourawski's formula leaves out
        assert_allclose(found.stress(FORCES)[:, 2], ours[:, 2], rtol=0.04)
    assert np.all(found.stress(FORCES)[:, 2] > 0.9 * ours[:, 2])


def test_a_beam_bends_and_twists_as_with_its_own_section() -> None:
    steel = Material(E=2e11, nu=0.3)
    own, shape, mesh, sizes = SHAPES["rectangle"]
    tips = []
    for section in (own, Section.from_sectionproperties(analysed(shape, mesh, **sizes), unit=1e-3)):
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (0.3, 0.0, 0.0))
        frame.add("AB", Beam(section, steel, shear=True), "A", "B")
        frame.fix("A")
        frame.load("B", fx=1e3, fy=10.0, fz=np.linspace(1.0, 20.0, 3), mx=2.0)
        solution = frame.solve()
        tips.append((solution.displacement("B"), solution.stress("AB", [0.0, 0.15, 0.3])))
    assert_allclose(tips[1][0], tips[0][0], rtol=1e-3, atol=1e-12)
    assert_allclose(tips[1][1], tips[0][1], rtol=0.05)


def test_principal_axes_of_an_angle() -> None:
    """Second moments by the tensor's eigenvalues; the tip under a force along an axis goes along it."""
    legs = analysed("angle_section", 1.0, d=20, b=10, t=2, r_r=0, r_t=0, n_r=2)
    with pytest.raises(FrameError, match=r"the product of inertia is -514.3 .*give principal=True"):
        Section.from_sectionproperties(legs)
    with pytest.warns(UserWarning, match="the shear centre lies at y = "):
        found = Section.from_sectionproperties(legs, principal=True)
    parts = [((1.0, 10.0), (2.0, 20.0)), ((6.0, 1.0), (8.0, 2.0))]
    area = sum(b * d for _, (b, d) in parts)
    x, y = (sum(b * d * place[k] for place, (b, d) in parts) / area for k in (0, 1))
    about_x = sum(b * d**3 / 12 + b * d * (place[1] - y) ** 2 for place, (b, d) in parts)
    about_y = sum(d * b**3 / 12 + b * d * (place[0] - x) ** 2 for place, (b, d) in parts)
    mixed = sum(b * d * (place[0] - x) * (place[1] - y) for place, (b, d) in parts)
    least, most = np.linalg.eigvalsh([[about_x, mixed], [mixed, about_y]])
    assert_allclose((found.A, found.Iy, found.Iz), (area, most, least), rtol=1e-10)
    # What a unit force makes adds up to it: fibres are turned with the axes. Nodes lie about evenly.
    assert found.fibres is not None
    by_y, by_z = found.fibres[:, [2, 5]].mean(axis=0), found.fibres[:, [3, 6]].mean(axis=0)
    assert abs(by_y[0] * area - 1.0) < 0.3 > abs(by_y[1] * area)
    assert abs(by_z[1] * area - 1.0) < 0.3 > abs(by_z[0] * area)
    # Bending about x alone, by both second moments and the product of inertia.
    corners = np.array([(0, 0), (10, 0), (10, 2), (2, 2), (2, 20), (0, 20)]) - [x, y]
    slopes = np.linalg.solve([[about_y, mixed], [mixed, about_x]], [0.0, 1.0])
    stress = corners @ slopes
    turn = np.radians(legs_turned_by(legs))
    moment = (np.cos(turn), -np.sin(turn))
    assert_allclose(found.stress([0, 0, 0, 0, *moment])[:2], (stress.min(), stress.max()), rtol=1e-9)


def legs_turned_by(geometry: Any) -> float:
    """Angle of the first principal axis, degrees."""
    from sectionproperties.analysis import Section as Analysis

    section = Analysis(geometry)
    section.calculate_geometric_properties()
    return float(section.section_props.phi)


def test_what_is_refused() -> None:
    geometry = pytest.importorskip("sectionproperties.pre.library").rectangular_section(d=20, b=10)
    with pytest.raises(FrameError, match="the geometry has no mesh: call its create_mesh"):
        Section.from_sectionproperties(geometry)
    from sectionproperties.analysis import Section as Analysis

    section = Analysis(geometry.create_mesh([4.0]))
    with pytest.raises(FrameError, match="call its calculate_geometric_properties"):
        Section.from_sectionproperties(section)
    section.calculate_geometric_properties()
    with pytest.raises(FrameError, match="call its calculate_warping_properties"):
        Section.from_sectionproperties(section)
    with pytest.raises(FrameError, match="was given a float"):
        Section.from_sectionproperties(2.0)
    with pytest.raises(FrameError, match="unit = 0 must be a positive number"):
        Section.from_sectionproperties(section, unit=0)
    from sectionproperties.pre import Material as Given

    steel = Given("steel", 2e5, 0.3, 250, 7.85e-6, "grey")
    library = pytest.importorskip("sectionproperties.pre.library")
    with pytest.raises(FrameError, match="the section has materials of its own"):
        Section.from_sectionproperties(library.rectangular_section(d=20, b=10, material=steel).create_mesh([4.0]))


def given() -> Section:
    """A square by its corners, of which the shear is that of a thin strip: no package is needed."""
    corners = [(y, z, 1.5, 0.0, 4.8, 0.0, 1.5, 4.8) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    return Section(A=1.0, Iy=1 / 12, Iz=1 / 12, J=0.141, fibres=np.array(corners))


def test_stress_at_fibres() -> None:
    section: CrossSection = given()
    forces = np.random.default_rng(0).normal(size=(3, 4, 6))
    N, Vy, Vz, T, My, Mz = np.moveaxis(forces, -1, 0)
    normal = np.stack([N - 12 * Mz * y + 12 * My * z for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    shear = (1.5 * Vy + 4.8 * T) ** 2 + (1.5 * Vz + 4.8 * T) ** 2
    whole = np.stack([normal.min(axis=0), normal.max(axis=0), np.sqrt(normal**2 + 3 * shear).max(axis=0)], axis=-1)
    assert_allclose(section.stress(forces), whole, rtol=1e-13)
    with pytest.raises(FrameError, match=r"fibres of shape \(2, 3\) must be rows of eight"):
        Section(A=1.0, Iy=1.0, Iz=1.0, J=1.0, fibres=np.zeros((2, 3)))


def test_fibres_are_kept_in_files(tmp_path: Path) -> None:
    linkage = Linkage(A=(0, 0), B=(2, 0))
    linkage.link("arm", "A", "B", beam=Beam(given(), Material(E=1.0, nu=0.3)))
    linkage.revolute("A", "ground", "arm", drive=True)
    write_linkage(linkage, tmp_path / "arm.toml")
    (beam,) = read_linkage(tmp_path / "arm.toml").links["arm"].beams.values()
    assert isinstance(beam, Beam)
    assert isinstance(beam.section, Section)
    assert beam.section.fibres is not None
    assert np.array_equal(beam.section.fibres, given().fibres)  # type: ignore[arg-type]
