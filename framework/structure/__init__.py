"""A description made into numbers: stacks of members, joint-relative coordinates, matrices."""
