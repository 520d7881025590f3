"""Files for ParaView."""

from ..lazily import loaded_later

# The command line reads its options before anything that computes is loaded.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["entries"])
