"""The site (tools/make_site.py), by Sphinx. Its pages are the repository's own, in a copy of its tree; only index and api are the site's."""

import os

project = "Polhode"
copyright = "2026 The Polhode authors, Apache-2.0"
version = release = os.environ["POLHODE_VERSION"]
extensions = ["myst_parser", "breathe"]
exclude_patterns = ["doxygen"]
root_doc = "index"

html_theme = "alabaster"
html_theme_options = {"description": "Motion and shape of a tumbling object from one camera", "fixed_sidebar": True, "page_width": "1200px",
                      "sidebar_width": "260px"}
html_sidebars = {"**": ["about.html", "searchfield.html", "navigation.html", "relations.html"]}
html_show_sourcelink = False

myst_heading_anchors = 4  # links to a place within a page
# The interface control document begins its sections below its title; a table's cell may hold any mark.
suppress_warnings = ["myst.header"]

breathe_projects = {"polhode": "doxygen/xml"}
breathe_default_project = "polhode"
breathe_domain_by_extension = {"h": "c", "hpp": "cpp"}
# Names of the standard library and of OpenCV are documented elsewhere.
highlight_language = "none"
