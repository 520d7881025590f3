"""Portal frame with clamped feet, pushed sideways at the corner.

    H → B-----------C
        |           |      the columns share the push; their feet carry moments that
        |           | h    follow from the stiffness of the beam against theirs,
        A           D      k = (I_beam / I_column) (h / L)
       ///---- L ---///

For bars that do not stretch A. Kleinlogel, Rahmenformeln, gives the moments in the feet: both
H h (3 k + 1) / (2 (6 k + 1)), and in the corners H h 3 k / (2 (6 k + 1)).
"""

from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame

PUSH, HEIGHT, SPAN = 1000.0, 3.0, 5.0
steel = Material(E=210e9, nu=0.3)
column = Section(A=1.0, Iy=2e-5, Iz=2e-5, J=1e-5)  # so thick that it hardly stretches
beam = Section(A=1.0, Iy=5e-5, Iz=5e-5, J=1e-5)

frame = Frame()
for name, place in {"A": (0, 0), "B": (0, HEIGHT), "C": (SPAN, HEIGHT), "D": (SPAN, 0)}.items():
    frame.node(name, (*place, 0.0))
frame.add("left", Beam(column, steel), "A", "B")
frame.add("top", Beam(beam, steel), "B", "C")
frame.add("right", Beam(column, steel), "D", "C")
frame.fix("A")
frame.fix("D")
frame.load("B", fx=PUSH)
solution = frame.solve()

sway = solution.displacement("B")[0]
foot_moments = solution.reaction("A")[5], solution.reaction("D")[5]
corner_moment = solution.forces("top", [0.0])[0, 5]

if __name__ == "__main__":
    print(f"sway           {1e3 * sway:8.3f} mm")
    print("foot moments  ", *(f"{moment:9.2f}" for moment in foot_moments), "N m")
    print(f"corner moment  {corner_moment:8.2f} N m")
