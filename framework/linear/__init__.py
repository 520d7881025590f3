"""The linear solution of a frame by subject: unknowns and solver, states, results, error bounds and validity."""
