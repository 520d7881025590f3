"""Linkages in files: writing and reading them, with errors that name the line and the key."""

from ....framework.lazily import loaded_later

# The command line reads its options before it loads what reads a linkage.
__getattr__, __dir__ = loaded_later(
    __name__, {}, modules=["read", "read_linkage", "sketch_file", "source", "write_linkage"]
)
