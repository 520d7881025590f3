"""Continuation from the reference configuration to every pose, on one branch."""
