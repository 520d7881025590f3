"""A calculation as a flat list of operations: recorded once, run by NumPy or as machine code.

`recording` records it, by doing arithmetic on `Term` objects; `program` is the list; `calculation` runs it for a batch,
by `numpy_backend` or `machine_code`, whichever is expected to be faster.
"""
