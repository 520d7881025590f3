"""When Newton's method has found an equilibrium, and how far it may go."""

from __future__ import annotations

# Work of the last Newton step, relative to the strain energy: squared again by the step itself.
CLOSE = 1e-16
# Iterations after which one that has not settled wanders, and smaller steps find their way in less.
ITERATIONS = 16
# Share of what loads of that size could do that is rounding, and drives no free motion to either side.
NEITHER = 3e-8
# Roundings of an eigenvalue, as `Newton.zero` has them, within which a motion is free.
FREE = 64.0
# Pivot, in units of the diagonal, above which all are clear of what the last step still changes.
CLEAR = 1e-8
# Longest step, and one that is nothing, in radians or sizes of the frame.
LONGEST, NOTHING = 1.0, 1e-13
