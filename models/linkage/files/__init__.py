"""Linkages in files: written, read, and pointed at by line and key where they are wrong."""
