"""The job of the accuracy paper: its example, its Table 1 and figures, and its numbers compared with a run."""
