"""A linkage with tolerances on its numbers: which numbers, their samples, and what becomes of its points."""
