"""Bodies and pictures of the deformed structure."""

from ..lazily import loaded_later

# The command line reads its options before anything that draws is loaded.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["drawing", "drawing_process", "rendering"])
