"""Where a point can be placed, and how stiff and well conditioned the linkage is there."""
