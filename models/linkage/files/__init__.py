"""Linkages in files: writing and reading them, with errors that name the line and the key."""
