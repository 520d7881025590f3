"""Linkages in files: written, read, and pointed at by line and key where they are wrong."""

from .read_linkage import read_linkage
from .write_linkage import write_linkage

__all__ = ["read_linkage", "write_linkage"]
