"""Clearance in joints: where each journal rests."""
