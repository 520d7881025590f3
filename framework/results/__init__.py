"""Results of a frame: displacements, forces and stresses, status, free motions, condition numbers, modes, buckling."""

from ..lazily import loaded_later

# A description and a static solution need neither.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["buckling", "modes"])
