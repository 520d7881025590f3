"""What is special about poses: mobility, dead points, singularity, transmission."""
