"""Equilibrium at large displacement: corotational members, finite rotation in joints, Newton and arc length."""
