"""One large frame, or a batch of middle-sized ones: their matrices, and the ways to solve them."""
