"""The solver for batches of small frames: an LDLᵀ of one sparse pattern whose entries are arrays that broadcast.

Terms of this folder:

- A *mask* is a bit set of the batch axes over which a number varies: 0 for a constant, bit k for axis k.
- An entry of the matrix or a load is a sum of *parts*, arrays of different masks, kept apart by mask.
- A *row* is a linear combination of unknowns, a dict of factors by number of the unknown; a negative number -1 - s
  stands for right-hand-side parameter s.
- A *right-hand-side parameter* is a number that loads the equations: the number one (for constant loads) and the
  prescribed displacements, offsets and loads that vary over the batch. Loads are carried per unit of each.
- The *scale* of a diagonal entry is the sum of stiffnesses whose rounding errors it contains; the *pivot ratio* is that
  of a pivot to its scale, about the rounding unit where the matrix is singular.
- A *program* is a list of arithmetic operations recorded once and run for each chunk of the batch, or for each frame of
  the same topology (`linkframe.framework.program`).
"""
