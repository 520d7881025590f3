"""Beam on an elastic foundation, by a form of scikit-fem's added to the frame's own matrices.

                    | F
                    v
    A===============B===============C      deflection below F (Hetényi, Beams on Elastic Foundation, 1946, ch. III)
    :  :  :  :  :  :  :  :  :  :  :  :
    |<------------- L ------------->|      F λ / 2 k (cosh λL + cos λL + 2) / (sinh λL + sin λL),  λ⁴ = k / 4 E I

What linkframe assembles is ordinary scikit-fem, `frame.matrices()` and `frame.basis()`; what one adds is a form.
Given to the frame, it is in all that the frame answers: a batch of foundations, with bounds on the error.
"""

import numpy as np
import skfem
from linkframe.elements import Beam, Material, Rectangle
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
    return w.k * u[1] * v[1]


by = frame.matrices()
K = by.K + foundation.assemble(frame.basis(), k=FOUNDATION)
u = skfem.solve(*skfem.condense(K, by.f, D=by.D))
(below,) = by.dofs.get_vertex_dofs([1]).all(["uy"])
deflection = -u[below]

softer = FOUNDATION * np.array([1.0, 0.5, 0.25])
frame.add_form(foundation, on="beam", k=softer)
solution = frame.solve()
deflections, bound = -solution.displacement("B")[:, 1], solution.error_bound("B")[:, 1]

stretch = (softer / (4.0 * 210e9 * 0.04 * 0.06**3 / 12.0)) ** 0.25
size = stretch * LENGTH
expected = FORCE * stretch / (2.0 * softer) * (np.cosh(size) + np.cos(size) + 2.0) / (np.sinh(size) + np.sin(size))

if __name__ == "__main__":
    print(f"deflection below the load {1e3 * deflection:.6f} mm, exactly {1e3 * expected[0]:.6f} mm")
    print(f"on softer ground {1e3 * deflections} mm, exactly {1e3 * expected} mm, within {1e3 * bound} mm")
