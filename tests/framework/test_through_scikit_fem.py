"""Which calls go into scikit-fem: matrices solved there, elements by their section law, tapers, files for ParaView; and
that a batch of prismatic beams makes none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skfem
from linkframe.elements import Beam, Joint, Material, PointMass, Rectangle
from linkframe.elements.forms import rigidity_of, stiffness
from linkframe.framework import Frame, LineElement, cubic_shapes
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
BAR, STEEL = Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3, density=7850.0)
TAPER = Beam(BAR, STEEL, end=Rectangle(y=0.01, z=0.01))


@dataclass(frozen=True, eq=False)
class BySectionLaw(LineElement):
    """A prismatic beam that gives its section law and shape functions, and no matrix."""

    shape = ()

    def section_flexibility(self, fraction: Array) -> Array:
        return Beam(BAR, STEEL).section_flexibility(fraction)

    def shape_functions(self, length: Array, x: Array) -> Array:
        return cubic_shapes(length, x)

    def mass_per_length(self, fraction: Array) -> Array:
        return Beam(BAR, STEEL).mass_per_length(fraction)


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often scikit-fem was called, by what was called there."""
    seen: Counter[str] = Counter()

    def watch(owner: type, method: str, name: Callable[[Any], str]) -> None:
        original = getattr(owner, method)

        def counted(self: Any, *given: Any, **named: Any) -> Any:
            seen[name(self)] += 1
            return original(self, *given, **named)

        monkeypatch.setattr(owner, method, counted)

    watch(skfem.MeshLine1, "__post_init__", lambda mesh: "mesh")
    watch(skfem.Dofs, "__init__", lambda dofs: "dofs")
    watch(skfem.Basis, "__init__", lambda basis: "basis")
    for kind in (skfem.BilinearForm, skfem.LinearForm):
        watch(kind, "elemental", lambda form: f"form of {form.form.__name__.strip('_')}")
    return seen


def cantilever(rod: LineElement, force: ArrayLike = -10.0) -> Frame:
    """Two members in a row, clamped at the start and loaded at the end across and along."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", rod, "A", "B")
    frame.add("BC", rod, "B", "C")
    frame.fix("A")
    frame.load("C", fy=force, fx=-1.0)
    return frame


def test_matrices_are_numbered_and_solved_by_scikit_fem(calls: Counter[str]) -> None:
    frame = cantilever(Beam(BAR, STEEL))
    by = frame.matrices()
    moved = skfem.solve(*skfem.condense(by.K, by.f, x=by.x, D=by.D))
    assert calls["mesh"]
    assert calls["dofs"]
    (tip,) = by.dofs.get_vertex_dofs([2]).all(["uy"])
    assert_allclose(moved[tip], frame.solve().displacement("C")[1], rtol=1e-10)


def test_a_basis_of_the_frame_is_scikit_fems(calls: Counter[str]) -> None:
    rod = Beam(BAR, STEEL)
    frame = cantilever(rod)
    basis = frame.basis("beam", intorder=2)
    matrix = stiffness.assemble(basis, rigidity=rigidity_of(rod, basis))
    assert calls["mesh"]
    assert calls["basis"] == 1
    assert_allclose(matrix.toarray(), frame.matrices().K.toarray(), atol=1e-9 * abs(matrix).max())


@pytest.mark.parametrize(
    ("answer", "forms"),
    [
        (lambda frame: frame.matrices(), {"stiffness", "mass"}),
        (lambda frame: frame.solve("sparse").displacement("C"), {"stiffness"}),
        (lambda frame: frame.modes(1), {"stiffness", "mass"}),
        (lambda frame: frame.buckling(1), {"geometric"}),
    ],
    ids=["matrices", "statics", "modes", "buckling"],
)
def test_an_element_by_its_section_law(calls: Counter[str], answer: Callable[[Frame], object], forms: set[str]) -> None:
    frame = cantilever(BySectionLaw())
    calls.clear()
    answer(frame)
    assert {name.removeprefix("form of ") for name in calls if name.startswith("form")} == forms
    assert calls["basis"]
    assert calls["mesh"]


def test_matrices_of_a_taper(calls: Counter[str]) -> None:
    """Its stiffness is the integral of the flexibility, in closed sums; its mass and geometric stiffness are forms."""
    cantilever(TAPER).solve().displacement("C")
    assert not calls
    cantilever(TAPER).modes(1)
    cantilever(TAPER).buckling(1)
    assert calls["form of mass"]
    assert calls["form of geometric"]
    assert not calls["form of stiffness"]


def test_paraview_cells_come_from_the_mesh(calls: Counter[str], tmp_path: Path) -> None:
    solution = cantilever(Beam(BAR, STEEL)).solve()
    solution.displacement("C")
    assert not calls
    solution.save(tmp_path / "frame.vtu")
    assert calls["mesh"]


def test_a_batch_of_prismatic_beams_makes_no_call(calls: Counter[str]) -> None:
    """An assembled matrix for each entry would take some thirty times as long; joints and masses change nothing."""
    frame = cantilever(Beam(BAR, STEEL), force=np.linspace(-10.0, 10.0, 300))
    frame.node("D", (2.0, 0.0, 0.0))
    frame.add("hinge", Joint(stiffness=(1e9, 1e9, 1e9, 1e6, 1e6, 5.0)), "C", "D")
    frame.add("block", PointMass(1.0), "D")
    solution = frame.solve()
    solution.displacements(), solution.reactions(), solution.forces("AB", [0.0, 0.5]), solution.error_bound("C")
    frame.modes(1)
    frame.buckling(1)
    assert not calls
