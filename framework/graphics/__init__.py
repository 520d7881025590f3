"""Figures with matplotlib: scenes of lines, joint symbols and texts, and functions that draw them."""

from ..lazily import loaded_later

# Most solutions are never drawn.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["plots"])
