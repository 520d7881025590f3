"""Bounds on the rounding errors of linear results, and derivatives of results by every input (adjoint method).

Terms of this folder. *Coordinates* are the displacements of nodes relative to what carries them in the joint tree,
(..., nodes, 6); the *unknowns* are the free ones among them. *Links* are joints, rigid links, ties and supports.
*Springs* are the deformations of members, each with its stiffness: ``K = sum_i k_i b_i b_i^T``. The *size* of a sum is
the sum of the magnitudes of its terms: its rounding error is a multiple of that, not of the sum itself.
"""
