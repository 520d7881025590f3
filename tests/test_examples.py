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


def test_pictures(tmp_path: Path) -> None:
    """Four panels: the linkage twice, the joints' forces in one curve, and moments that vanish in the pins."""
    shown = example("pictures")
    at_rest, moving, forces, bending = shown.draw(tmp_path / "pictures.png").axes
    crank = next(line for line in at_rest.lines if line.get_label() == "crank")
    assert_allclose(crank.get_xydata(), [shown.linkage.points[point][:2] for point in "AB"], atol=1e-12)
    (path,) = (line for line in moving.lines if line.get_gid() == "trace")
    assert_allclose(path.get_xydata(), shown.motion.position("P")[:, :2], atol=1e-12)
    assert [line.get_label() for line in forces.lines] == ["A, B, D, E"]
    # Half the load in each pin of the coupler, 0.1 m from it: 5 N m.
    told = [text.get_text() for text in bending.texts if text.get_gid() == "value"]
    assert "−5" in told


def test_scikit_fem_form() -> None:
    shown = example("scikit_fem_form")
    assert_allclose(shown.deflection, shown.expected[0], rtol=1e-6)
    assert_allclose(shown.expected[0], 2.067142e-3, rtol=1e-6)
    assert_allclose(shown.deflections, shown.expected, rtol=1e-6)
    assert abs(shown.deflections[0] - shown.deflection) < shown.bound[0] + 1e-9 * shown.deflection


def test_own_truss() -> None:
    shown = example("own_truss")
    assert_allclose(shown.sinking, 1000.0 * 2.0 / (2.0 * shown.stiffness * np.sin(np.radians(50.0)) ** 2), rtol=1e-12)


def test_own_foundation() -> None:
    shown = example("own_foundation")
    assert_allclose(shown.deflection, shown.expected, rtol=1e-5)


def test_own_cable() -> None:
    shown = example("own_cable")
    assert shown.status["left"].tolist() == ["slack", "taut", "taut"]
    assert shown.status["right"].tolist() == ["taut", "slack", "slack"]
    along = np.abs(shown.force) * np.hypot(3.0, 2.0) / 2.0
    assert_allclose(shown.pull["left"] + shown.pull["right"], along, rtol=1e-12)
    for name, pull in shown.pull.items():
        assert (np.abs(shown.by_law.forces(name, [0.0])[:, 0, 0] - pull) <= 1e-2 * along).all()


def test_own_heated_beam() -> None:
    shown = example("own_heated_beam")
    curvature = -1.2e-5 * shown.gradient
    assert_allclose(shown.lift, curvature * 2.0**2 / 2.0, rtol=1e-12)
    assert_allclose(shown.growth, 1.2e-5 * 20.0 * 2.0, rtol=1e-12)
    assert_allclose(shown.moment, -210e9 * 0.05 * 0.1**3 / 12.0 * curvature, rtol=1e-12)


def test_own_hardening_spring() -> None:
    shown = example("own_hardening_spring")
    assert_allclose(1000.0 * shown.elongation + 4e4 * shown.elongation**3, shown.force, rtol=1e-9)
    assert shown.linear.linear.tolist() == [True, False, False]


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


def test_slider_crank() -> None:
    shown = example("slider_crank")
    assert_allclose(shown.piston, shown.place(shown.theta), rtol=1e-14)
    assert_allclose(shown.velocity, shown.slope(shown.theta) * 10.0, atol=1e-14)
    ends = np.sqrt(np.array([0.2 - 0.05, 0.2 + 0.05]) ** 2 - 0.012**2)
    assert_allclose([point.value for point in shown.ends], ends, rtol=0.0, atol=1e-12)
    assert [point.joint for point in shown.ends] == ["B", "B"]
    assert_allclose(np.cos(shown.transmission), np.abs(0.05 * np.sin(shown.theta) - 0.012) / 0.2, rtol=0.0, atol=1e-12)


def between(chord: complex, first: float, second: float, side: float) -> complex:
    """Pin of two bars over a chord, from its start: cosine law."""
    along = (abs(chord) ** 2 + first**2 - second**2) / (2.0 * abs(chord))
    return (along + side * 1j * np.sqrt(first**2 - along**2)) * chord / abs(chord)


def test_six_bar() -> None:
    """Back from the crank angles that were found, link after link by the cosine law, to the angles of the arm."""
    shown = example("six_bar")
    a, b, p, d, e, f, g = (complex(*shown.linkage.points[name][:2]) for name in "ABPDEFG")
    for crank, swing in zip(shown.crank, shown.swing, strict=True):
        pin = a + (b - a) * np.exp(1j * crank)
        end = pin + between(e - pin, abs(d - b), abs(e - d), 1.0)
        point = pin + (p - b) * (end - pin) / (d - b)
        top = point + between(g - point, abs(f - p), abs(g - f), 1.0)
        assert abs(np.angle((top - g) / (f - g)) - swing) < 1e-12
    assert np.nanmax(shown.motion.gap) < 1e-15
    # Beside the ends of its range the arm is nearly powerless.
    assert shown.motion.conditioning[[0, -1]].max() < 0.5 * shown.motion.conditioning.max()


def test_andrews_squeezer() -> None:
    """After 0.03 s of the published motion (Test Set for IVP Solvers), at its crank angle."""
    shown = example("andrews_squeezer")
    assert (shown.mobility.actual, shown.mobility.kutzbach) == (1, 1)
    assert shown.motion.gap.max() < 1e-15
    published = (
        *(15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948),
        *(0.5244099658805303, 0.5347301163226948, 1.048080741042263),
    )
    motion = shown.linkage.move(O=np.linspace(shown.START[0], published[0], 9))
    for name, place in shown.points(*published).items():
        assert_allclose(motion.position(name)[-1, :2], place, rtol=0.0, atol=1e-14)


def test_five_bar() -> None:
    shown = example("five_bar")
    assert_allclose(shown.path, shown.wanted, rtol=0.0, atol=1e-14)
    assert shown.mobility.actual == 2
    # At the lowest point the linkage is symmetric: B is where two circles meet on the left.
    b = shown.motion.position("B")[0, 0] + 1j * shown.motion.position("B")[0, 1]
    assert_allclose([abs(b + 0.1), abs(b - 0.4j)], [0.3, 0.4], rtol=1e-14)


def test_three_rrr() -> None:
    shown = example("three_rrr")
    assert_allclose(shown.path[:, 0] + 1j * shown.path[:, 1], shown.place, rtol=0.0, atol=1e-14)
    assert_allclose(np.arctan2(shown.axes[:, 1, 0], shown.axes[:, 0, 0]), shown.turn, rtol=0.0, atol=1e-13)
    for k in range(3):
        away = shown.motion.position(f"B{k}") - shown.motion.position(f"C{k}", "platform")
        assert_allclose(np.linalg.norm(away, axis=-1), 0.25, rtol=1e-14)


def test_scissor_lift() -> None:
    shown = example("scissor_lift")
    height = 5 * np.sqrt(1.0 - shown.feet**2)
    assert_allclose(shown.height, height, rtol=1e-13)
    assert_allclose(shown.speed, 0.1 * 25 * shown.feet / height, rtol=1e-12)
    assert_allclose(shown.push, -1000.0 * 25 * shown.feet / height, rtol=1e-10)
    assert_allclose([point.value for point in shown.flat], [-1.0, 0.0, 1.0], rtol=0.0, atol=1e-10)
    assert [point.change_point for point in shown.flat] == [False, True, False]
    for stages in (1, 2):
        lift = shown.lift(stages)
        assert lift.mobility().actual == lift.mobility().kutzbach == 1
        assert_allclose(lift.move(push=0.8).position(f"L{stages}")[1], stages * 0.6, rtol=1e-14)


def test_rssr() -> None:
    shown = example("rssr")
    assert_allclose(shown.angle, shown.rocker_angle(shown.theta), rtol=0.0, atol=1e-13)
    assert (shown.mobility.actual, shown.mobility.kutzbach, shown.mobility.idle) == (2, 2, ("rod",))
    assert (shown.motion.status == "regular").all()


def test_bennett() -> None:
    shown = example("bennett")
    first, second = shown.turns[:2]
    ratio = np.sin(np.radians(45.0)) / np.sin(np.radians(15.0))
    off = np.sin(first / 2) * np.sin(second / 2) - ratio * np.cos(first / 2) * np.cos(second / 2)
    assert_allclose(off, 0.0, atol=1e-14)
    assert_allclose(shown.turns[2:], -shown.turns[:2], rtol=0.0, atol=1e-13)
    assert (shown.mobility.actual, shown.mobility.kutzbach, len(shown.mobility.redundant)) == (1, -2, 3)


def test_bricard() -> None:
    shown = example("bricard")
    theta, phi = np.cos(shown.turns[0]), np.cos(shown.turns[1])
    assert_allclose(theta + phi + theta * phi, 0.0, atol=1e-14)
    assert_allclose(shown.turns[2:], shown.turns[[0, 1, 0, 1]], rtol=0.0, atol=1e-12)
    assert (shown.mobility.actual, shown.mobility.kutzbach, len(shown.mobility.redundant)) == (1, 0, 1)


def test_cardan_shaft() -> None:
    shown = example("cardan_shaft")
    cosine = np.cos(np.radians(30.0))
    assert_allclose(shown.output, shown.theta, rtol=0.0, atol=1e-14)
    assert_allclose(
        np.sin(shown.theta) * np.cos(shown.shaft), cosine * np.cos(shown.theta) * np.sin(shown.shaft), atol=1e-14
    )
    assert_allclose(
        shown.shaft_speed, cosine / (1.0 - np.sin(np.radians(30.0)) ** 2 * np.cos(shown.theta) ** 2), rtol=1e-13
    )


def test_delta_robot() -> None:
    shown = example("delta_robot")
    assert_allclose(shown.path, shown.wanted, rtol=0.0, atol=1e-14)
    assert_allclose(shown.axes, np.broadcast_to(np.eye(3), shown.axes.shape), rtol=0.0, atol=1e-13)
    for k in range(3):
        for side in "lr":
            away = shown.motion.position(f"B{k}{side}", f"arm {k}") - shown.motion.position(f"C{k}{side}", "platform")
            assert_allclose(np.linalg.norm(away, axis=-1), 0.5, rtol=1e-14)


def test_stewart_platform() -> None:
    shown = example("stewart_platform")
    assert_allclose(shown.path, shown.place, rtol=0.0, atol=1e-13)
    assert_allclose(shown.axes, shown.turn.as_matrix(), rtol=0.0, atol=1e-13)
    assert (shown.mobility.actual, shown.mobility.kutzbach, shown.mobility.redundant) == (6, 6, ())


def test_excavator() -> None:
    """The bucket's edge by cosine laws alone, and the cylinders' forces by virtual work."""
    shown = example("excavator")
    at = {name: complex(*place) for name, place in shown.POINTS.items()}

    def opened(corner: str, foot: str, head: str, length: float) -> complex:
        """Turn of a triangle's corner as the cylinder across it takes a new length."""
        first, second = at[foot] - at[corner], at[head] - at[corner]
        now = np.arccos((abs(first) ** 2 + abs(second) ** 2 - length**2) / (2.0 * abs(first) * abs(second)))
        drawn = np.angle(second / first)
        return complex(np.exp(1j * (np.sign(drawn) * now - drawn)))

    def edge(boom: float, stick: float, bucket: float) -> complex:
        lift = opened("O", "F", "G", boom)
        bend = lift * opened("S", "H", "I", stick)
        k = at["R"] + opened("R", "J", "K", bucket) * (at["K"] - at["R"])
        side = np.sign(((at["L"] - at["K"]) * np.conj(at["T"] - at["K"])).imag)
        corner = k + between(at["T"] - k, abs(at["L"] - at["K"]), abs(at["L"] - at["T"]), side)
        tip = at["T"] + (at["E"] - at["T"]) * (corner - at["T"]) / (at["L"] - at["T"])
        return lift * at["S"] + bend * (tip - at["S"])

    strokes = np.stack([shown.stroke[name] for name in shown.CYLINDERS], axis=-1)
    forces = np.stack([shown.thrust[name] for name in shown.CYLINDERS], axis=-1)
    for number, stroke in enumerate(strokes):
        assert abs(complex(*shown.edge[number, :2]) - edge(*stroke)) < 1e-12
        step = 1e-5 * np.eye(3)
        moved = [(edge(*(stroke + one)) - edge(*(stroke - one))).real / 2e-5 for one in step]
        assert_allclose(forces[number], -50e3 * np.array(moved), rtol=1e-6, atol=1e-2)
    assert shown.mobility.actual == 3


def test_four_bar_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)
    example("four_bar_picture").draw(tmp_path / "four_bar.png")
    assert (tmp_path / "four_bar.png").stat().st_size > 10_000


@pytest.mark.parametrize("name", ["slider_crank", "cardan_shaft"])
def test_linkage_pictures(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import pyvista

    monkeypatch.syspath_prepend(EXAMPLES)
    example("linkage_pictures").show(name, tmp_path)
    assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    reader = pyvista.PVDReader(tmp_path / f"{name}.pvd")
    motion = example(name).motion
    assert len(reader.time_values) == len(motion.gap)
    reader.set_active_time_point(7)
    points = reader.read()[0]["links"].points
    wanted = [motion.position(point, link)[7] for link, own in motion.linkage.links.items() for point in own.points]
    assert_allclose(points, wanted, rtol=0.0, atol=1e-15)


def test_every_linkage_has_its_picture() -> None:
    traced = example("linkage_pictures").TRACED
    described = {path.stem for path in EXAMPLES.glob("*.py") if "import Linkage" in path.read_text(encoding="utf-8")}
    # The others are linkages of these scripts again, of which other things are shown.
    again = {"worst_case", "optimal_six_bar", "reliability", "workspace_stiffness"}
    again |= {"gravity_spring_rpm", "measured_data", "own_linkage_study"}
    assert set(traced) == described - again
    for name, points in traced.items():
        assert set(points) <= set(example(name).linkage.points)


@pytest.mark.parametrize("picture", sorted(EXAMPLES.glob("*.png")), ids=lambda path: path.name)
def test_pictures_are_small(picture: Path) -> None:
    assert picture.stat().st_size < 250_000


def test_the_picture_in_readme_is_drawn_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the script, with the same linkages in the same places."""
    from matplotlib.image import imread

    monkeypatch.syspath_prepend(EXAMPLES)
    example("linkage_pictures").gallery(tmp_path / "linkages.png")
    drawn, shown = imread(tmp_path / "linkages.png"), imread(EXAMPLES / "linkages.png")
    assert drawn.shape == shown.shape
    # Fonts may differ; in every one of the ten fields there is as much ink as in README's picture.
    fields = [np.mean(image[..., :3].min(axis=-1) < 0.9) for image in _fields(drawn)]
    assert_allclose(fields, [np.mean(image[..., :3].min(axis=-1) < 0.9) for image in _fields(shown)], rtol=0.1)


def _fields(picture: np.ndarray) -> list[np.ndarray]:
    return [field for row in np.split(picture, 2) for field in np.split(row, 5, axis=1)]


def test_worst_case() -> None:
    """The rocker's pins carry one force, that of the rod between them; the support is the sum of the contributions."""
    shown = example("worst_case")
    assert shown.table.names[:4] == ("joint A", "joint B", "joint D", "joint E")
    assert_allclose(shown.table.reach[:, 2], shown.table.reach[:, 3], rtol=1e-9)
    assert_allclose(shown.table.reach.sum(axis=1), shown.worst.greatest, rtol=1e-9)
    across = np.linalg.norm(shown.band[:, 0] - shown.motion.position("P"), axis=1)
    assert (across <= shown.worst.greatest * (1.0 + 1e-12)).all()


def test_optimal_six_bar() -> None:
    """The gradient by 30 parameters is that of a difference in a random direction; it takes one solution."""
    shown = example("optimal_six_bar")
    along, step = np.random.default_rng(0).normal(size=30), 1e-5
    difference = (shown.cost(step * along)[0] - shown.cost(-step * along)[0]) / (2.0 * step)
    assert_allclose(shown.gradient @ along, difference, rtol=1e-7)
    assert shown.found.fun < 0.3 * shown.first
    assert shown.by_differences >= 20 * (shown.solutions - 2)


def test_loose_pins() -> None:
    """The reactions are those of the rigid linkage; its journals change sides where the one in E vanishes."""
    shown = example("loose_pins")
    reactions = shown.motion.reactions(coupler=Link(force=(0.0, 100.0), at=(0.5, 0.2)))
    force = {joint: reactions.reaction(joint) for joint in "BDE"}
    work = sum(eps * np.linalg.norm(force[joint], axis=-1) for joint, eps in shown.clearance.items())
    assert_allclose(shown.by_clearance, work / 100.0, rtol=1e-9)
    reverses = np.sum(force["E"][1:] * force["E"][:-1], axis=-1) < 0.0
    assert_allclose(np.radians(shown.changes), shown.theta[:-1][reverses])
    assert reverses.sum() > 0


def test_reliability() -> None:
    """Probabilities by first order, fits that hold, cuts from none to the worst case, and the crank that was built."""
    shown = example("reliability")
    slopes = shown.motion.sensitivity("C").lengths
    spread = shown.DEVIATION * np.hypot(slopes["crank"][:, 0], slopes["rod"][:, 0])
    assert_allclose(shown.failing.probability, 2.0 * shown.stats.norm.sf(shown.ALLOWED / spread), rtol=5e-3)
    step = 1e-6
    numeric = (shown.place(shown.theta, 0.05 + step) - shown.place(shown.theta, 0.05 - step)) / (2.0 * step)
    assert_allclose(slopes["crank"][:, 0], numeric, rtol=1e-7)
    assert shown.fits.greatest.max() <= 100e-6
    worst = 15e-6 * np.abs([slopes["crank"][:, 0], slopes["rod"][:, 0]]).sum(axis=0)
    assert_allclose(shown.fuzzy.upper[[0, 5, 10]], np.outer([1.0, 0.5, 0.0], worst), atol=1e-15)
    assert shown.comparison.p_value < 1e-6
    found, error = shown.calibration.values, shown.calibration.standard_error
    assert abs(found["crank"] - 0.05003) < 3.0 * error["crank"] < 5e-6
    assert abs(found["rod"] - 0.2) < 3.0 * error["rod"]


def test_workspace_stiffness() -> None:
    """Each leg is a spring along its rod; the platform's stiffness is the sum of theirs."""
    shown = example("workspace_stiffness")
    motion = shown.space.motion
    area, inertia = np.pi / 4.0 * (0.03**2 - 0.024**2), np.pi / 64.0 * (0.03**4 - 0.024**4)
    middle, stiffness = motion.position("P")[:, :2], np.zeros((len(motion.position("P")), 3, 3))
    for k in range(3):
        foot, elbow, corner = (motion.position(f"{name}{k}")[:, :2] for name in "ABC")
        rod, arm = ((end - start) / 0.25 for start, end in ((corner, elbow), (foot, elbow)))
        along = np.sum(rod * arm, axis=-1) ** 2
        soft = 0.25 / (70e9 * area) * (1.0 + along) + 0.25**3 / (3.0 * 70e9 * inertia) * (1.0 - along)
        turn = (corner - middle)[:, 0] * rod[:, 1] - (corner - middle)[:, 1] * rod[:, 0]
        acts = np.concatenate([rod, turn[:, None]], axis=-1)
        stiffness += acts[:, :, None] * acts[:, None, :] / soft[:, None, None]
    least = 1.0 / np.linalg.eigvalsh(np.linalg.inv(stiffness)[:, :2, :2])[:, -1]
    assert_allclose(shown.stiffness[shown.space.reached], least, rtol=1e-8)
    assert 280 < shown.space.reached.sum() < 360


def test_gravity_spring_rpm() -> None:
    """The torque is the derivative of the energy by the crank's angle, here of Python's own floats."""
    shown = example("gravity_spring_rpm")
    crank, rod, ram, speed = shown.CRANK, shown.ROD, shown.RAM, shown.SPEED
    line = 7850.0 * 0.03 * 0.012
    slice_turn = 7850.0 * 0.03**3 * 0.012 / 12.0  # per length, of the section about its own axis

    def energy(angle: float) -> float:
        pin = crank * np.array([np.cos(angle), np.sin(angle)])
        up = np.sqrt(rod**2 - pin[0] ** 2)
        pin_speed = speed * np.array([-pin[1], pin[0]])
        ram_speed = pin_speed[1] - pin[0] * pin_speed[0] / up
        middle = 0.5 * (pin_speed + np.array([0.0, ram_speed]))
        turn = pin_speed[0] / up
        kinetic = 0.5 * (ram * ram_speed**2 + line * crank * (speed * crank) ** 2 / 3.0 + slice_turn * crank * speed**2)
        kinetic += 0.5 * (line * rod * (middle @ middle + (turn * rod) ** 2 / 12.0) + slice_turn * rod * turn**2)
        height = line * crank * 0.5 * pin[1] + line * rod * (pin[1] + 0.5 * up) + ram * (pin[1] + up)
        return float(kinetic + 9.81 * height + 0.5 * shown.RATE * (0.35 - pin[1] - up - shown.REST) ** 2)

    step = 1e-5
    torque = [(energy(a + step) - energy(a - step)) / (2.0 * step) for a in shown.angle]
    assert_allclose(shown.torque, torque, atol=1e-5 * np.abs(torque).max())
    assert abs(shown.torque.mean()) < 1e-9


def test_sizing() -> None:
    shown = example("sizing")
    along = np.array([[-2.0, -0.5], [-2.0, 1.0]])  # from C to A and to B
    forces = np.linalg.solve((along / np.linalg.norm(along, axis=1)[:, None]).T, [0.0, 20e3])
    areas = np.abs(forces) * np.sum(np.abs(forces) * shown.lengths) / (210e9 * 20e3 * 2e-3)
    assert_allclose(np.pi / 4.0 * shown.diameters**2, areas, rtol=1e-4)
    assert shown.found.fun == pytest.approx(7850.0 * areas @ shown.lengths, rel=1e-6)
    assert shown.sinking == pytest.approx(2e-3, rel=1e-6)


def test_measured_data() -> None:
    shown = example("measured_data")
    assert shown.nominal.p_value < 1e-9
    assert shown.as_built.p_value > 0.05
    for name, true in (("crank", 0.1), ("coupler", 0.3002)):
        assert abs(shown.calibration.values[name] - true) < 3.0 * shown.calibration.standard_error[name]
    axes = shown.nominal.plot()
    assert axes.get_title(loc="left").startswith("χ² = 2791 of 48 components")
    marked = next(line for line in axes.lines if line.get_label() == "outside")
    assert marked.get_xdata().tolist() == np.flatnonzero(shown.nominal.outside).tolist()


def test_own_linkage_study() -> None:
    """The lower lever has a force along itself alone: the journal in D lies against its bearing along the lever."""
    shown = example("own_linkage_study")
    found, motion = shown.found, shown.motion
    assert (found.status == "regular").all()
    lever = motion.position("K") - motion.position("D")
    lever /= np.linalg.norm(lever, axis=-1, keepdims=True)
    gap = motion.frame().solve().joint_displacement("D")[:, :2]
    assert_allclose(np.linalg.norm(gap, axis=-1), 30e-6 + 2000.0 / lever[:, 1] / 4e8, rtol=1e-4)
    # The ram is led: half of a clearance in D, spread evenly, and the spread of the load on what deflects.
    assert_allclose(found.std[0, :, 0], 0.0, atol=1e-9)
    least = np.hypot(15e-6 / lever[:, 1], 0.05 * found.compliance[0, :, 1]) / np.sqrt(3.0)
    assert (found.std[0, :, 1] > 0.98 * least).all()
    assert (found.std[0, :, 1] < 1.5 * least).all()
    assert found.contributors["D"].ranked[0] == "joint D"
