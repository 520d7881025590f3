"""Worst case of clearances and tolerances: regions that a point can reach, and the fits that keep it in a zone."""
