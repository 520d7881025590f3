"""A calculation as a flat list of operations: recorded once, run by NumPy or as machine code."""
