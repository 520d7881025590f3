"""Every example runs and shows what it says, against the closed form in its sketch."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from linkframe.models import Link
from numpy.testing import assert_allclose

EXAMPLES = Path(__file__).parents[1] / "examples"


def example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_example_is_tested() -> None:
    here = Path(__file__).read_text(encoding="utf-8")
    for path in EXAMPLES.glob("*.py"):
        assert f'example("{path.stem}")' in here


def test_cantilever() -> None:
    shown = example("cantilever")
    inertia = 10e-3 * 20e-3**3 / 12.0
    assert_allclose(shown.deflection, -200.0 * 0.5**3 / (3.0 * 210e9 * inertia), rtol=1e-13)
    assert_allclose(shown.clamping_moment, 200.0 * 0.5, rtol=1e-13)
    assert_allclose(shown.greatest_stress, 200.0 * 0.5 * 10e-3 / inertia, rtol=1e-13)


def test_portal_frame() -> None:
    shown = example("portal_frame")
    k = (5e-5 / 2e-5) * (3.0 / 5.0)
    foot = 1000.0 * 3.0 * (3.0 * k + 1.0) / (2.0 * (6.0 * k + 1.0))
    corner = 1000.0 * 3.0 * 3.0 * k / (2.0 * (6.0 * k + 1.0))
    # The columns are 1 m² of steel and stretch by 1e-5 of the sway.
    assert_allclose(shown.foot_moments, foot, rtol=1e-4)
    assert_allclose(abs(shown.corner_moment), corner, rtol=1e-4)
    assert_allclose(sum(shown.foot_moments) + 2.0 * abs(shown.corner_moment), 1000.0 * 3.0, rtol=1e-4)


def test_three_hinged_frame() -> None:
    shown = example("three_hinged_frame")
    lift, thrust = 1000.0 * 3.0 / 4.0, 600.0 * 4.0 / (4.0 * 3.0)
    assert_allclose(shown.feet["A"], [thrust - 500.0, 300.0 - lift], rtol=1e-9)
    assert_allclose(shown.feet["E"], [-thrust - 500.0, 300.0 + lift], rtol=1e-9)
    assert abs(shown.moment_beside_hinge) < 1e-6
    # By virtual work 2/EI (H h²/3 + H h L/2 − W L²/16); the bars also stretch a little.
    stiffness = 210e9 * 0.05 * 0.1**3 / 12.0
    turn = 2.0 / stiffness * (thrust * 3.0**2 / 3.0 + thrust * 3.0 * 4.0 / 2.0 - 600.0 * 4.0**2 / 16.0)
    assert_allclose(shown.opening, turn, rtol=1e-3)


def test_batch_sweep() -> None:
    shown = example("batch_sweep")
    inertia = np.pi / 64.0 * (30e-3**4 - 26e-3**4)
    assert shown.deflection.shape == (5, 40)
    assert_allclose(shown.deflection, -shown.force * shown.length**3 / (3.0 * 70e9 * inertia), rtol=1e-12)


def test_four_bar() -> None:
    shown = example("four_bar")
    assert_allclose(shown.singular, [0.0, 180.0, 360.0], atol=1e-9)
    assert np.isnan(shown.compliance[shown.motion.singular]).all()
    # Mirrored in the ground line the linkage is the same, and the force points the other way.
    assert_allclose(shown.compliance, shown.compliance[::-1], rtol=1e-9)


def test_four_bar_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)
    example("four_bar_picture").draw(tmp_path / "four_bar.png")
    assert (tmp_path / "four_bar.png").stat().st_size > 10_000


@pytest.mark.parametrize("picture", sorted(EXAMPLES.glob("*.png")), ids=lambda path: path.name)
def test_pictures_are_small(picture: Path) -> None:
    assert picture.stat().st_size < 150_000


def test_loose_pins() -> None:
    """The reactions are those of the rigid linkage; its journals change sides where the one in E vanishes."""
    shown = example("loose_pins")
    reactions = shown.motion.reactions(coupler=Link(force=(0.0, 100.0), at=(0.5, 0.2)))
    force = {joint: reactions.reaction(joint) for joint in "BDE"}
    work = sum(eps * np.linalg.norm(force[joint], axis=-1) for joint, eps in shown.clearance.items())
    assert_allclose(shown.play, work / 100.0, rtol=1e-9)
    reverses = np.sum(force["E"][1:] * force["E"][:-1], axis=-1) < 0.0
    assert_allclose(np.radians(shown.thrown), shown.theta[:-1][reverses])
    assert reverses.sum() > 0
