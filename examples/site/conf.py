"""The documentation site: ``sphinx-build -W examples/site build/site``."""

import sys
from importlib.metadata import version as installed
from pathlib import Path

HERE = Path(__file__).parent
TOP = HERE.parents[1]
GENERATED = HERE / "generated"
sys.path.insert(0, str(HERE))

import gallery  # noqa: E402
import measured  # noqa: E402
import published  # noqa: E402

project = "linkframe"
author = copyright = "The linkframe developers"
version = release = installed("linkframe")

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "mathml",
    "numpydoc",
    "run_blocks",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["generated/examples", "**/*.inc"]
templates_path = ["templates"]
highlight_language = "none"

autosummary_generate = True
autodoc_typehints = "none"  # the text says types, shapes and units
autosummary_ignore_module_all = False
numpydoc_show_class_members = False

html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = f"linkframe {version}"
html_theme_options = {"secondary_sidebar_items": ["page-toc"], "show_prev_next": True, "navigation_with_keys": False}
html_show_sourcelink = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_sidebars = {page: [] for page in ("index", "tutorial", "theory", "validation", "benchmarks")}
html_extra_path = ["generated/live"]

sphinx_gallery_conf = {
    "examples_dirs": "generated/examples",
    "gallery_dirs": "generated/gallery",
    "filename_pattern": r"\.py$",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "within_subsection_order": "FileNameSortKey",
    "min_reported_time": 1e9,
    "write_computation_times": False,
}

gallery.prepare(TOP / "examples", GENERATED / "examples", GENERATED / "live")
measured.prepare(TOP / "README.md", GENERATED / "benchmarks.inc")
published.prepare(TOP, GENERATED / "validation.inc")
