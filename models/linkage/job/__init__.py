"""The job of ``linkframe run``: accuracy of any linkage in a file, as ``linkframe four-bar`` for that of the paper."""
