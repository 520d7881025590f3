"""scikit-fem forms of frame analysis (stiffness, mass, geometric stiffness, loads), for a `Basis` of
`ElementLineFrame`.
"""

from __future__ import annotations

from ..framework.scikit_fem.forms import (
    geometric,
    inertia_of,
    initial_of,
    internal_forces,
    load,
    mass,
    restrained,
    rigidity_of,
    section_forces,
    stiffness,
    strains,
)

__all__ = [
    "geometric",
    "inertia_of",
    "initial_of",
    "internal_forces",
    "load",
    "mass",
    "restrained",
    "rigidity_of",
    "section_forces",
    "stiffness",
    "strains",
]
