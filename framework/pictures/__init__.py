"""Bodies and pictures of the deformed structure."""
