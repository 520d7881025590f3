"""Where everything is at each pose, and what is special about it: mobility, dead points, singularity."""
