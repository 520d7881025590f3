"""Shared parts of the jobs of the command line: stages, output folder, tables, figures."""
