"""Loops as equations, and Newton's method on them."""
