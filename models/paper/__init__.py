"""The job of the accuracy paper: its example, its Table 1 and figures, and its numbers compared with a run."""

from ...framework.lazily import loaded_later

# Options are read before anything that computes is loaded, and tables need nothing that draws.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["drawing", "job", "page"])
