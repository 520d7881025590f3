"""The job of ``linkframe run``: accuracy of any linkage in a file, as ``linkframe four-bar`` for that of the paper."""

from ....framework.lazily import loaded_later

# Options are read before anything that computes is loaded.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["inputs", "page", "run"])
