"""Equilibrium at large displacement: corotational members, finite rotation in joints, Newton's method and arc length.

The way through this folder follows the data:

- **Numbers.** `numbers` (members and loads), `joints` with `links` (what resists in joints, links and supports, and how
  they carry one node by another) and `planes` (which entries keep to a plane) hold the frame by entry of a batch;
  `model` puts them together and numbers the coordinates of the joint tree. `state` is where the frame is.
- **Equations.** `corotation` and `response` are the members; `equations` has energy, unbalanced forces and tangent in
  space, `planar_equations` in a plane (of `planar_pieces` and `planar_model`), on what both share in `tree_equations`.
- **Newton's method.** `elimination` solves for a step and `newton` takes it; `recorded_newton` writes the same down as
  a program, which `newton_program` runs on long batches. `accuracy` tells what rounding leaves of what is found.
- **Search.** Where Newton's method fails, `search` takes smaller steps, leaves a `saddle` of the energy along its mode,
  or goes down the energy by `descent`. `clearances` finds where journals lie; `load_stepping` brings all entries to
  their whole load, `path` follows them past limit points.
- **Results.** `recovery` has forces and displacements of members and joints, `solution` answers by name, `by_planes`
  joins what was solved plane by plane.
"""

from ..lazily import loaded_later

# A description and a linear solution need neither.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["by_planes", "path"])
