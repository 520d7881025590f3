"""Results of a frame: displacements, forces and stresses, status, free motions, condition numbers, modes, buckling."""
