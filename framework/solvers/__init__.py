"""One large frame: the matrix by node blocks, and the ways to solve it."""
