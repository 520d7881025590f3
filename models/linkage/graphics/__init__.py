"""Figures, pictures, movies and CAD drawings of a linkage and its motion."""

from ....framework.lazily import loaded_later

# Few motions are drawn.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["bodies", "pictures", "plots", "reaction_plots"])
