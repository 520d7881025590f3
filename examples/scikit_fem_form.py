"""Beam on an elastic foundation, by a form of scikit-fem's added to the frame's own matrices.

                    | F
                    v
    A===============B===============C      deflection below F (Hetényi, Beams on Elastic Foundation, 1946, ch. III)
    :  :  :  :  :  :  :  :  :  :  :  :
    |<------------- L ------------->|      F λ / 2 k (cosh λL + cos λL + 2) / (sinh λL + sin λL),  λ⁴ = k / 4 E I

What linkframe assembles is ordinary scikit-fem: `frame.mesh` and `frame.matrices()`; what one adds is a `BilinearForm`.
"""

import numpy as np
import skfem
from linkframe.elements import ArcLengthMapping, Beam, ElementLineFrame, Material, Rectangle
from linkframe.framework import Frame

LENGTH, FORCE, FOUNDATION = 4.0, 1000.0, 2e5  # m, N, N/m per metre
beam = Beam(Rectangle(y=0.06, z=0.04), Material(E=210e9, nu=0.3), segments=16)

frame = Frame()
frame.node("A", (0.0, 0.0, 0.0))
frame.node("B", (LENGTH / 2, 0.0, 0.0))
frame.node("C", (LENGTH, 0.0, 0.0))
frame.add("AB", beam, "A", "B")
frame.add("BC", beam, "B", "C")
frame.fix("A", "ux", "uz", "rx", "ry")
frame.load("B", fy=-FORCE)


@skfem.BilinearForm
def foundation(u, v, w):
    """Springs along the members, across them in their local y."""
    return FOUNDATION * u[1] * v[1]


by = frame.matrices()
basis = skfem.Basis(by.mesh, ElementLineFrame(beam), ArcLengthMapping(by.mesh), intorder=6)
u = skfem.solve(*skfem.condense(by.K + foundation.assemble(basis), by.f, D=by.D))
(below,) = by.dofs.get_vertex_dofs([1]).all(["uy"])
deflection = -u[below]

stretch = (FOUNDATION / (4.0 * 210e9 * 0.04 * 0.06**3 / 12.0)) ** 0.25
size = stretch * LENGTH
expected = FORCE * stretch / (2.0 * FOUNDATION) * (np.cosh(size) + np.cos(size) + 2.0) / (np.sinh(size) + np.sin(size))

if __name__ == "__main__":
    print(f"deflection below the load {1e3 * deflection:.6f} mm, exactly {1e3 * expected:.6f} mm")
