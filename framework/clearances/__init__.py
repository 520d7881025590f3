"""Clearance in joints: the contact state of each journal in its bearing, found together with the elastic solution."""

from ..lazily import loaded_later

# Few frames have clearance.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["clearance", "contact_search"])
