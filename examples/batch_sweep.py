"""A whole study as one frame: lengths along one axis, loads along another.

    |==============o        five lengths  (5, 1)
    0      L       |        × forty loads   (40,)
                   v F      = two hundred cantilevers, displacement (5, 40, 6)

Nothing is looped over. What varies with the length is factorised five times, and not two hundred times.
"""

import numpy as np
from linkframe.elements import Beam, Material, Tube
from linkframe.framework import Frame

length = np.linspace(0.4, 1.2, 5)[:, None]
force = np.linspace(10.0, 400.0, 40)
pipe = Tube(outer=30e-3, thickness=2e-3)

end = np.zeros((*length.shape, 3))
end[..., 0] = length

frame = Frame()
frame.node("A", (0.0, 0.0, 0.0))
frame.node("B", end)
frame.add("AB", Beam(pipe, Material(E=70e9, nu=0.33)), "A", "B")
frame.fix("A")
frame.load("B", fy=-force)
solution = frame.solve()

deflection = solution.displacement("B")[..., 1]

if __name__ == "__main__":
    print(frame.explain())
    print(f"deflections {deflection.shape}, from {1e3 * deflection.max():.3f} to {1e3 * deflection.min():.3f} mm")
