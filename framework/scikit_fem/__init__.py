"""Members in scikit-fem: a line mesh in space, forms, and matrices of one member by quadrature."""

from ..lazily import loaded_later

# Members with springs or closed forms need no quadrature, with which all of scikit-fem is loaded.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["integrals"])
