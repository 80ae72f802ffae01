"""Settings of the documentation site: ``python -m sphinx -W -b html docs site``."""

from __future__ import annotations

import re
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent / "_site"), str(Path(__file__).parents[1])]

from sphinx.application import Sphinx  # noqa: E402

import wmr_ctrl  # noqa: E402  # the line above makes it found

project = "wmr_ctrl"
copyright = "the wmr_ctrl developers"
release = version = wmr_ctrl.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_click",
    "sphinx_copybutton",
    # Ours, in docs/_site.
    "contents",
    "live",
    "mathml",
    "notebooks",
    "pages",
]
root_doc = "index"
exclude_patterns = ["_site", "Thumbs.db", ".DS_Store"]

# Every name that is referred to exists, but for those of other packages, whose documentation is
# not there when the site is built without a network.
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|np|casadi|ca|control|pandas|xarray|matplotlib|click|os|pathlib)\b.*"),
    ("py:.*", r"(collections\.abc|typing)\..*"),
    ("py:obj", r"[\s\S]*"),  # what docstrings put into single quotes, commands too
    # Annotations: names that only type checkers import, type variables, and values whose
    # fields are on another page.
    ("py:class", r"[A-Z]\w*"),
    ("py:class", r"(.*\.)?S|tuple\[.*"),
    # Annotations name classes by the file that they are in; the pages have public names.
    ("py:class", r"wmr_ctrl\.[a-z_0-9]+\..*"),
    ("py:class", r"types\.(LawGiven|Overrides|Progress)|concurrent\.futures\..*"),
]
suppress_warnings = ["config.cache"]

# Markdown
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
myst_dmath_double_inline = True
html_math_renderer = "mathml"

# Docstrings: single quotes name something of this package
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True

ARRAY = re.compile(r"[~\w.]*ndarray\[tuple\[[~\w.]*Any, \.\.\.\], [~\w.]*dtype\[[~\w.]*float64\]\]")

copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True

smartquotes = False  # options begin with two dashes

html_theme = "furo"
html_title = f"wmr_ctrl {release}"
html_static_path = ["_site/static"]
html_css_files = ["site.css"]
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#1F5F9E", "color-brand-content": "#1F5F9E"},
    "dark_css_variables": {"color-brand-primary": "#7DB7F0", "color-brand-content": "#7DB7F0"},
}
html_show_sourcelink = False
html_copy_source = False
pygments_style = "friendly"
pygments_dark_style = "monokai"


def setup(app: Sphinx) -> None:
    """Show array types by the names that the code uses for them."""

    def by_name(*given: object) -> tuple[str | None, str | None]:
        signature, result = (text and ARRAY.sub("Floats", str(text)) for text in given[-2:])
        return signature, result

    app.connect("autodoc-process-signature", by_name)
