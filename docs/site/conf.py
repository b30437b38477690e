"""How Sphinx builds the site from the pages that stage.py has put together; run by `make docs`."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

project = "soft-gripper"
copyright = "the soft-gripper authors, BSD-3-Clause"
version = release = installed_version("soft-gripper")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_design", "docstrings", "mathml"]
source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb"}

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # notebooks have their outputs with them
nb_merge_streams = True

autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autoclass_content = "both"
autodoc_inherit_docstrings = False  # a block without a constructor of its own would have Drake's
napoleon_google_docstring = napoleon_numpy_docstring = False  # docstrings.py calls it
highlight_language = "none"  # what is indented is output, a diagram or a command
default_role = "py:obj"  # docstrings name things in single backticks

html_theme = "furo"
html_title = f"soft-gripper {version}"
html_logo = html_favicon = "static/logo.svg"
html_math_renderer = "mathml"
html_theme_options = {
    f"{scheme}_css_variables": {f"color-brand-{part}": color for part in ("primary", "content", "visited")}
    for scheme, color in (("light", "#0b7a7a"), ("dark", "#4fd1c5"))
}
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = [("version_menu.js", {"defer": "defer"})]
html_copy_source = False
templates_path: list[str] = []
