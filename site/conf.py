"""Sphinx over docs/ and over what Doxygen finds in the headers; scripts/site lays the sources out and calls it."""

import logging
import os
import re

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
suppress_warnings = ["myst.header"]


class NamespaceInEveryHeader(logging.Filter):
    """breathe declares a namespace once for each header that opens it; Sphinx warns about the second declaration."""

    def filter(self, record):
        return not re.search(r"Duplicate C\+\+ declaration.*cpp:type:: (saccade|detail|lab|sweep)'", record.getMessage(), re.S)


def setup(app):
    logging.getLogger("sphinx.sphinx.domains.cpp").filters.insert(0, NamespaceInEveryHeader())
html_theme = "alabaster"
html_title = f"saccade {release}".strip()
html_theme_options = {"description": "Closed-loop testbench for event-driven vision on the iCub", "page_width": "min(1500px, 95%)",
                      "body_max_width": "1200px",  # for the tables; the default is 800 px
                      "sidebar_width": "240px", "fixed_sidebar": True}
html_extra_path = [name for name in ["demo"] if os.path.isdir(name)]
html_show_sourcelink = False
html_copy_source = False
