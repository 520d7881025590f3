"""From the drawing to every pose, on one branch."""
