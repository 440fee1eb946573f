"""Sphinx over docs/ and over what Doxygen finds in the headers; scripts/site lays the sources out and calls it."""

import os

project = "saccade"
author = "The saccade authors"
release = os.environ.get("SACCADE_VERSION", "")
extensions = ["myst_parser"]
if os.environ.get("SACCADE_DOXYGEN_XML"):
    extensions.append("breathe")
    breathe_projects = {"saccade": os.environ["SACCADE_DOXYGEN_XML"]}
    breathe_default_project = "saccade"
    breathe_show_include = False
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["build"]
myst_heading_anchors = 4
# Links to files of the repository that are no pages of the site, and the same name of overloads in several headers.
suppress_warnings = ["myst.xref_missing", "myst.header", "duplicate_declaration.cpp"]
html_theme = "alabaster"
html_title = f"saccade {release}".strip()
html_theme_options = {"description": "Closed-loop testbench for event-driven vision on the iCub", "page_width": "1080px",
                      "sidebar_width": "240px", "fixed_sidebar": True}
html_show_sourcelink = False
html_copy_source = False
