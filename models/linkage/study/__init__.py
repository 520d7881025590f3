"""Tolerances of a linkage's numbers: which numbers they concern, samples, and the displacements of points."""
