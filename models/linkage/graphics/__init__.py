"""What figures show of a linkage and its motion."""
