"""Solvers for one large frame (sparse, banded, iterative) and for a batch of middle-sized ones (banded).

The choice among them is made in `method`; all of them solve with a `Factor`, or a `StackedFactor` for batches.
"""
