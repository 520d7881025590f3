"""From a description to equations: numbering, stacks of members, joint-relative coordinates, stiffness and loads."""

from ..lazily import loaded_later

# A description alone is not numbered.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["topology"])
