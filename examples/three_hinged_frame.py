"""Three-hinged frame: an ideal joint in the middle of the beam, pinned feet.

              | W
              v
    H → B-----o-----C     statically determinate: against the push each foot carries H / 2
        |   M   N   |     to the left and H h / L down or up, against the weight W / 2 upwards
        | h         |     and the thrust W L / 4 h inwards
        A           E
        ^---- L ----^

The nodes M and N lie on one place; the joint between them holds everything but the turn about z. The hinge is ideal: no
spring stands for it, and its opening is a result of its own.
"""

from math import inf

from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame

PUSH, WEIGHT, HEIGHT, SPAN = 1000.0, 600.0, 3.0, 4.0
bar = Beam(Rectangle(y=0.1, z=0.05), Material(E=210e9, nu=0.3))
crown = (SPAN / 2, HEIGHT, 0.0)

frame = Frame()
for name, place in {
    "A": (0, 0, 0),
    "B": (0, HEIGHT, 0),
    "M": crown,
    "N": crown,
    "C": (SPAN, HEIGHT, 0),
    "E": (SPAN, 0, 0),
}.items():
    frame.node(name, place)
for member in ("AB", "BM", "NC", "CE"):
    frame.add(member, bar, *member)
frame.add("hinge", Joint(stiffness=(inf, inf, inf, inf, inf, 0.0)), "M", "N")
for foot in "AE":
    frame.fix(foot, "ux", "uy", "uz", "rx", "ry")
frame.load("B", fx=PUSH)
frame.load("M", fy=-WEIGHT)
solution = frame.solve()

feet = {foot: solution.reaction(foot)[:2] for foot in "AE"}
opening = solution.joint_displacement("hinge")[5]
moment_beside_hinge = solution.forces("BM", [SPAN / 2])[0, 5]

if __name__ == "__main__":
    for foot, force in feet.items():
        print(f"force on foot {foot}: {force[0]:8.2f} {force[1]:8.2f} N")
    print(f"the hinge opens by {1e3 * opening:.4f} mrad; moment beside it {moment_beside_hinge:.1e} N m")
