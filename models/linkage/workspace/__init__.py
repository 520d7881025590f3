"""The workspace of a point: which places it can reach, and stiffness, condition and drive effort there."""
