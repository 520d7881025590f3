"""Forces and compliance of a moving linkage."""
