"""The linear solution of a frame by subject: what is solved, its states, its results, and how far they hold."""
