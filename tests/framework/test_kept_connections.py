"""Frames that are connected and supported alike share what follows from that, and change nothing of each other."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.batched.plan import Plan
from linkframe.framework.cache import PATTERNS, TERMS
from reference.own_elements import Softer

STEEL = Material(E=200e9, nu=0.3)
BAR = Rectangle(y=0.03, z=0.02)
FEW = 24


@pytest.fixture(autouse=True)
def _nothing_known() -> Iterator[None]:
    forget()
    yield
    forget()


def forget() -> None:
    PATTERNS.clear()
    TERMS.clear()


def chain(beam: Beam, *, length: float = 1.0, fixed: tuple[str, ...] = (), bend: float = 0.0) -> Frame:
    """A cantilever of equal members along x, bent in the plane where asked for."""
    frame = Frame()
    for k, x in enumerate(np.linspace(0.0, length, FEW + 1).tolist()):
        frame.node(f"{k}", (x, bend * x * x, 0.0))
    for k in range(FEW):
        frame.add(f"m{k}", beam, f"{k}", f"{k + 1}")
    frame.fix("0")
    if fixed:
        frame.fix(f"{FEW}", *fixed)
    frame.load(f"{FEW // 2}", fy=-3.0, fx=1.0)
    frame.load(f"{FEW}", fy=10.0, fz=2.0, mx=1.0)
    return frame


VARIANTS = {
    "as it is": lambda: chain(Beam(BAR, STEEL)),
    "softer": lambda: chain(Beam(BAR, Material(E=70e9, nu=0.3))),
    "batch of moduli": lambda: chain(Beam(BAR, Material(E=np.linspace(1e11, 2e11, 5), nu=0.3))),
    "longer": lambda: chain(Beam(BAR, STEEL), length=2.0),
    "bent": lambda: chain(Beam(BAR, STEEL), bend=0.3),
    "turned": lambda: chain(Beam(BAR, STEEL, up=(0.0, 1.0, 1.0))),
    "released": lambda: chain(Beam(BAR, STEEL, release=("end rz",)), fixed=("uy", "rz", "uz")),
    "tapered": lambda: chain(Beam(BAR, STEEL, end=Rectangle(y=0.02, z=0.02))),
    "propped": lambda: chain(Beam(BAR, STEEL), fixed=("uy",)),
    "propped in z": lambda: chain(Beam(BAR, STEEL), fixed=("uz",)),
}


@pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")
def test_what_other_frames_leave_changes_no_bit() -> None:
    """Each after all others, with what these leave, is as it is alone."""
    alone = {}
    for name, make in VARIANTS.items():
        forget()
        alone[name] = make().solve().displacements()
    for _ in range(2):
        for name, make in VARIANTS.items():
            np.testing.assert_array_equal(make().solve().displacements(), alone[name], err_msg=name)


def test_connections_are_shared_by_content() -> None:
    """Lengths and moduli have no part in them; what is held, and whether that is displaced, has."""
    links = {name: Plan(make()).graph.links for name, make in VARIANTS.items()}
    for name in ("softer", "batch of moduli", "longer", "bent", "turned", "tapered"):
        assert links[name] is links["as it is"]
    assert links["propped"] is not links["as it is"]
    assert links["propped"] is not links["propped in z"]
    pushed = VARIANTS["propped"]()
    pushed.prescribe(f"{FEW}", uy=1e-3)
    assert Plan(pushed).graph.links.key is None


def test_a_displaced_support_is_no_support_at_rest() -> None:
    """A prop that is pushed by d bends a cantilever under no load by ``3 E I d / L^3`` at its end."""
    bar = Beam(BAR, STEEL)
    VARIANTS["propped"]().solve().displacement("1")
    pushed = chain(bar, fixed=("uy",))
    pushed.loads.clear()
    pushed.prescribe(f"{FEW}", uy=1e-3)
    expected = 3.0 * 200e9 * bar.section.Iz * 1e-3
    assert pushed.solve().reaction(f"{FEW}")[1] == pytest.approx(expected, rel=1e-11)
    assert VARIANTS["propped"]().solve().reaction(f"{FEW}")[1] < 0.0


def test_nothing_that_is_kept_holds_a_description() -> None:
    frame = VARIANTS["batch of moduli"]()
    frame.solve().displacement("1")
    member = weakref.ref(frame.members["m1"].element)
    del frame
    gc.collect()
    assert member() is None


@pytest.mark.parametrize("modulus", [200e9, np.linspace(1e11, 2e11, 40)])
def test_beams_of_ones_own_between_the_same_places(modulus: float | np.ndarray) -> None:
    """Half as stiff, they are displaced twice as far, whatever is known of others."""
    material = Material(E=modulus, nu=0.3)
    for _ in range(2):
        plain, soft = (chain(kind(BAR, material)).solve().displacements() for kind in (Beam, Softer))
        np.testing.assert_allclose(soft, 2.0 * plain, rtol=1e-12, atol=1e-15)


def test_what_elements_deform_as() -> None:
    """Their numbers have no part in it but where a taper moves the elastic centre."""
    assert Beam(BAR, STEEL).deforms_as == Beam(Circle(diameter=0.1), Material(E=1.0, nu=0.2), shear=True).deforms_as
    assert Beam(BAR, STEEL).deforms_as != Beam(BAR, STEEL, release=("end rz",)).deforms_as
    assert Beam(BAR, STEEL, up=(0, 1, 0)).deforms_as != Beam(BAR, STEEL, up=(0, 1, 1)).deforms_as
    assert Beam(BAR, STEEL, end=Rectangle(y=0.02, z=0.02)).deforms_as is None
    assert Beam(BAR, STEEL, up=np.eye(3)).deforms_as is None
    assert Softer(BAR, STEEL).deforms_as is None


@pytest.mark.parametrize("name", VARIANTS)
def test_stiffness_of_springs_alone(name: str) -> None:
    beam = VARIANTS[name]().members["m0"].element
    for length in (0.7, np.linspace(0.5, 2.0, 4)[:, None]):
        np.testing.assert_array_equal(beam.spring_stiffness(length), beam.springs(length)[0])


def test_supports_at_rest_are_one_number_that_stays() -> None:
    frame = chain(Beam(BAR, STEEL))
    with pytest.raises(ValueError, match="read-only"):
        frame.supports["0"][0] += 1.0
    joined = Frame()
    for name in "AB":
        joined.node(name, (0.0, 0.0, 0.0))
    joined.node("C", (1.0, 0.0, 0.0))
    joined.add("pin", Joint(stiffness=(1e6,) * 6), "A", "B")
    joined.add("BC", Beam(BAR, STEEL), "B", "C")
    joined.fix("A")
    assert Plan(joined).graph.links.key is None
