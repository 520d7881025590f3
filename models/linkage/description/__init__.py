"""The description of a linkage: points, links, joints, drives, springs and loads, with their checks."""
