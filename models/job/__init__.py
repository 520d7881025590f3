"""Shared parts of the jobs of the command line: stages, output folder, tables, figures."""

from ...framework.lazily import loaded_later

# Options are read before anything that computes is loaded, and tables need nothing that draws.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["figures", "force_figures", "measured", "parts", "run"])
