"""Sphinx configuration of the site (`build.py`)."""

import matplotlib as mpl

from beveloid_geom import __version__

mpl.use("Agg")

project = "beveloid-geom"
version = release = __version__
author = "the authors of beveloid-geom"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_gallery.gen_gallery"]
root_doc = "index"
default_role = "code"
highlight_language = "text"
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"{project} {release}"
html_show_copyright = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
python_maximum_signature_line_length = 90
sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "examples",
    "within_subsection_order": "FileNameSortKey",
    "show_memory": False,
    "min_reported_time": 1e9,
    "remove_config_comments": True,
    "download_all_examples": False,
    "show_signature": False,
    "abort_on_example_error": True,
}
