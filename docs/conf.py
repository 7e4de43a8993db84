"""The site of the documentation, without the network: `make docs` builds it, `make site-check` without running it."""

import sys
from importlib.metadata import version as installed
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "narrows"
author = copyright = "The narrows developers"
version = release = installed("narrows")
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "_extension.build",
]
exclude_patterns = ["_extension", "**/*.ipynb", "gallery/*.py", "gallery/GALLERY_HEADER.rst"]
suppress_warnings = ["ref.python"]  # Words in the types of docstrings, "(rows,)", are names of several attributes too.

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "force"  # A page that is kept would not follow the package.
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_execution_in_temp = True  # A page that saves a file leaves none in the folder of the docs.
nb_ipywidgets_js: dict[str, dict[str, str]] = {}  # No page has widgets; their script would come from elsewhere.

autodoc_typehints = "none"  # The docstrings say types, shapes and units.
autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "image_scrapers": ("_extension.figures.figures_of_block",),
    "reset_modules": (),
    "capture_repr": (),
    "download_all_examples": False,
    "thumbnail_size": (600, 430),
    "within_subsection_order": "ExampleTitleSortKey",
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "run_stale_examples": True,
    "abort_on_example_error": True,
}

if tags.has("unrun"):  # noqa: F821  # of Sphinx: pages and links are checked, and nothing is run, which the tests do
    nb_execution_mode = "off"
    suppress_warnings.append("myst-nb.lexer")  # Of cells that no kernel has seen.
    sphinx_gallery_conf |= {"plot_gallery": False, "run_stale_examples": False}

mathjax_path = "mathjax.js"

html_theme = "pydata_sphinx_theme"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_title = f"narrows {release}"
html_sidebars = {page: [] for page in ("overview", "release-note", "changelog", "contributing")}
html_show_sourcelink = False
html_theme_options = {
    "logo": {"text": "narrows"},
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button"],
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
