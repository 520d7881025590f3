"""The job of ``linkframe run``: what ``four-bar`` does for the paper, for any linkage in a file."""
