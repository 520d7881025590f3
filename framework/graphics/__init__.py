"""Figures with matplotlib: scenes of lines, joint symbols and texts, and functions that draw them."""
