"""Contact in closed form, where offsets meet no stiffness: the same as by the search, and only where it holds."""

from __future__ import annotations

import pickle
import tracemalloc
from functools import partial

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, MechanismWarning, Solution
from linkframe.framework.clearances import contact_search, determinate
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3, density=7850.0))
INF = float("inf")
POSES, PINS = 4, ("B", "D", "E")


def four_bar(seed: int, samples: int = 60, size: ArrayLike = 1.0, poses: int = POSES) -> Frame:
    """A four-bar of random shape at some angles of its crank, which is clamped, with random pins and loads."""
    rng = np.random.default_rng(seed)
    turn = np.linspace(0.3, 5.5, poses)[:, None] + rng.uniform(0.0, 0.3)
    crank, coupler, rocker, ground = 0.1, *rng.uniform((0.28, 0.28, 0.28), (0.32, 0.32, 0.32))
    B = crank * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=-1)
    E = np.array([ground, 0.0, 0.0])
    across = E - B
    reach = np.linalg.norm(across, axis=-1, keepdims=True)
    along = (reach**2 + coupler**2 - rocker**2) / (2.0 * reach)
    normal = np.stack([-across[..., 1], across[..., 0], across[..., 2]], axis=-1) / reach
    D = B + along * across / reach + np.sqrt(coupler**2 - along**2) * normal
    P = B + rng.uniform(0.3, 0.7) * (D - B) + rng.uniform(0.02, 0.1) * normal
    frame = Frame()
    places = {"A": np.zeros(3), "B1": B, "B2": B, "P": P, "D2": D, "D3": D, "E3": E, "E": E}
    for name, place in places.items():
        frame.node(name, place)
    for start, end in (("A", "B1"), ("B2", "P"), ("P", "D2"), ("D3", "E3")):
        frame.add(start + end, BAR, start, end)
    for name, first, second in (("B", "B1", "B2"), ("D", "D2", "D3"), ("E", "E3", "E")):
        stiff = np.full((samples, 6), INF) if rng.integers(3) == 0 else np.full((samples, 6), 1e9)
        stiff[:, :2] *= rng.uniform(0.1, 2.0, (samples, 1))
        stiff[:, 5] = 0.0
        frame.add(name, Joint(stiff, clearance=rng.uniform(0.5e-3, 2e-3, samples)), first, second)
    frame.fix("A")
    frame.fix("E")
    frame.load("P", fx=size * rng.normal(0.0, 50.0, samples), fy=size * rng.normal(200.0, 20.0, samples))
    if seed % 2:
        frame.line_load("D3E3", fx=rng.normal(100.0, 10.0, samples))
        frame.gravity((0.0, -9.81, 0.0))
        frame.prescribe("A", rz=1e-3, ux=1e-4)
        frame.offset("D", ux=rng.normal(0.0, 1e-4, samples))
    return frame


def searched(frame: Frame, patch: pytest.MonkeyPatch) -> Solution:
    """The solution in which contact is sought in all joints, and their offsets are imposed on the frame."""
    with patch.context() as inside:
        inside.setattr(contact_search, "determinate_contact", lambda *_: None)
        return frame.solve()


@pytest.mark.parametrize("seed", range(4))
def test_the_same_as_by_the_search(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    frame = four_bar(seed)
    found, expected = frame.solve(), searched(frame, monkeypatch)
    assert found.pressed is not None
    assert expected.pressed is None
    for node in ("P", "B2", "E3"):
        mine, other = found.displacement(node), expected.displacement(node)
        assert_allclose(mine, other, rtol=0.0, atol=1e-13 * np.abs(other).max())
    for name in PINS:
        mine, other = found.contact(name), expected.contact(name)
        assert_array_equal(mine.status, other.status)
        assert_allclose(mine.force, other.force, rtol=1e-10)
        assert_allclose(mine.offset, other.offset, rtol=0.0, atol=1e-13)
        assert_allclose(found.joint_force(name), expected.joint_force(name), rtol=0.0, atol=1e-9)
        assert_allclose(found.joint_displacement(name), expected.joint_displacement(name), rtol=0.0, atol=1e-13)
    assert_allclose(found.reaction("A"), expected.reaction("A"), rtol=0.0, atol=1e-9)
    assert_allclose(found.end_forces("B2P"), expected.end_forces("B2P"), rtol=0.0, atol=1e-9)
    assert_array_equal(found.status, expected.status)
    assert "displacements are those without clearances" in found.explain()


def test_chunks_and_machine_code_give_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    frame = four_bar(1, 9_005)
    compiled = frame.solve().displacement("P")
    with monkeypatch.context() as patch:
        patch.setattr("linkframe.framework.program.machine_code.available", lambda: False)
        chunks = frame.solve().displacement("P")
        patch.setattr(determinate, "_FEW", 10**9)
        at_once = frame.solve().displacement("P")
    assert_array_equal(chunks, at_once)
    assert_allclose(compiled, chunks, rtol=0.0, atol=1e-15 * np.abs(chunks).max())


def test_an_entry_without_load_is_left_to_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing tells there where the journals are, which all results and a warning say."""
    loaded = np.arange(60) != 7
    found, expected = (solve(four_bar(2, size=loaded)) for solve in (Frame.solve, partial(searched, patch=monkeypatch)))
    for solution in (found, expected):
        with pytest.warns(MechanismWarning, match="4 of 240 batch entries are free"):
            solution.displacement("P")
    assert found.determinate is not None
    assert found.pressed is None
    assert_array_equal(found.status, expected.status)
    assert_allclose(found.displacement("P"), expected.displacement("P"), rtol=0.0, atol=1e-15)
    assert_array_equal(found.contact("D").status, np.where(np.tile(loaded, (POSES, 1)), "closed", "free"))


def test_a_force_that_rounding_may_have_made_is_left_to_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clamped crank bears 1 MN by itself; beside that, what 1e-10 N would press together is free."""

    def pressed_crank() -> Frame:
        frame = four_bar(2, size=np.where(np.arange(60) == 7, 1e-12, 1.0))
        frame.load("B1", fy=1e6)
        return frame

    found, expected = pressed_crank().solve(), searched(pressed_crank(), monkeypatch)
    for solution in (found, expected):
        with pytest.warns(MechanismWarning, match="4 of 240 batch entries are free"):
            solution.displacement("P")
    assert found.pressed is None
    assert_array_equal(found.status, expected.status)
    assert_array_equal(found.contact("D").status, np.where(np.tile(np.arange(60) == 7, (POSES, 1)), "free", "closed"))


def test_a_load_that_fades_away_is_still_one() -> None:
    """Contact depends on the direction of the load alone."""
    whole, faded = (four_bar(2, size=size).solve() for size in (1.0, 1e-30))
    assert faded.pressed is not None
    assert_allclose(faded.contact("B").normal, whole.contact("B").normal, rtol=0.0, atol=1e-14)


def test_a_spring_that_offsets_strain_takes_the_search() -> None:
    """One that is so soft that S is rounding beside the members, but tells where the links lie."""
    frame = four_bar(2)
    for name, end in (("turn", "B2"), ("turn too", "D3")):
        frame.node(name, frame.nodes[end].coordinates)
        frame.add(f"{name} spring", Joint((0.0, 0.0, 0.0, 0.0, 0.0, 1e-9)), end, name)
        frame.fix(name)
    assert frame.solve().pressed is None


def test_small_batches_go_the_quick_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """Even where motions vary over all of the batch."""
    quick, slow = four_bar(2, 2).solve(), searched(four_bar(2, 2), monkeypatch)
    assert quick.pressed is not None
    for joint in PINS:
        assert_allclose(quick.joint_force(joint), slow.joint_force(joint), rtol=0.0, atol=1e-9)
        assert_allclose(quick.contact(joint).offset, slow.contact(joint).offset, rtol=0.0, atol=1e-15)
    assert_allclose(quick.displacement("P"), slow.displacement("P"), rtol=1e-9, atol=1e-15)


def test_several_parts_and_single_entries_take_the_search() -> None:
    assert four_bar(2, 1, poses=1).solve().determinate is None
    frame = four_bar(2)
    for name, x in (("F", 1.0), ("G", 1.2)):
        frame.node(name, (x, 0.0, 0.0))
    frame.add("FG", BAR, "F", "G")
    frame.fix("F")
    frame.load("G", fy=1.0)
    assert frame.solve().determinate is None


def test_a_copy_answers_alike() -> None:
    solution = four_bar(3).solve()
    moved = solution.displacement("P")
    copy = pickle.loads(pickle.dumps(solution))
    assert copy.pressed is not None
    assert_array_equal(copy.displacement("P"), moved)
    assert_array_equal(copy.displacements(), solution.displacements())


def test_memory_is_that_of_the_answer() -> None:
    """Six numbers of displacement an entry, of which three vary, and less than as many again for the way there."""
    frame = four_bar(4, 16_000)
    frame.solve().displacement("P")
    tracemalloc.start()
    frame.solve().displacement("P")
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 20 * 8 * POSES * 16_000
