"""Clearance in joints: the contact state of each journal in its bearing, found together with the elastic solution."""
