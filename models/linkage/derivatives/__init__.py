"""Derivatives of positions and displacements by the dimensions, drives and other inputs of a linkage."""
