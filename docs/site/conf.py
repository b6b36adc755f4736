"""Settings of Sphinx."""

from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

from docs.site import diagrams
from ppaas import __version__

HERE = Path(__file__).parent

project = "PPaaS"
version = release = __version__
copyright = "the authors of PPaaS; Apache-2.0"  # noqa: A001 - the name that Sphinx takes
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
nitpicky = True
smartquotes = False
myst_heading_anchors = 4
myst_enable_extensions = ["html_image"]
myst_fence_as_directive = [diagrams.NAME]

html_theme = "furo"
html_title = f"PPaaS {__version__}"
html_favicon = str(HERE.parents[1] / "endpoints" / "dashboard" / "static" / "icon.svg")
html_static_path = [str(HERE / "static")]
html_css_files = ["site.css"]
templates_path = [str(HERE / "templates")]
html_copy_source = False
html_use_index = False


def setup(app: Sphinx) -> None:
    """Register what Sphinx lacks: diagrams, and a language that Pygments does not know."""
    app.add_lexer("haproxy", TextLexer)
    app.add_lexer("caddy", TextLexer)
    diagrams.setup(app)
