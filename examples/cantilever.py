"""Cantilever with a tip load.

              | F
    A         v
    |=========B      deflection  F L³ / 3 E I,   clamping moment  F L
    0         L

The bar stands on edge: its greater side is along local y, in the plane of bending.
"""

from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame

LENGTH, FORCE = 0.5, 200.0
steel = Material(E=210e9, nu=0.3, density=7850.0)
bar = Rectangle(y=20e-3, z=10e-3)

frame = Frame()
frame.node("A", (0.0, 0.0, 0.0))
frame.node("B", (LENGTH, 0.0, 0.0))
frame.add("AB", Beam(bar, steel), "A", "B")
frame.fix("A")
frame.load("B", fy=-FORCE)
solution = frame.solve()

deflection = solution.displacement("B")[1]
clamping_moment = solution.reaction("A")[5]
greatest_stress = solution.stress("AB", [0.0])[0, 1]

if __name__ == "__main__":
    print(f"deflection      {1e3 * deflection:8.4f} mm")
    print(f"clamping moment {clamping_moment:8.2f} N m")
    print(f"greatest stress {1e-6 * greatest_stress:8.2f} MPa")
