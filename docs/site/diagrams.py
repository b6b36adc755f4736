"""Diagrams of Mermaid: the browser draws them, by a script that only their pages load."""

import html
import shutil
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

NAME = "mermaid"
"""Language of the blocks that are diagrams, and class of their elements."""

_CLASS = "diagram"


class Diagram(SphinxDirective):
    """Text of a diagram, which remains readable where no script draws it."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return the text, for the script to draw."""
        text = html.escape("\n".join(self.content))
        return [nodes.raw("", f'<pre class="{NAME}">{text}</pre>', format="html", classes=[_CLASS])]


def setup(app: Sphinx) -> None:
    """Register the diagrams."""
    app.add_config_value("mermaid", "", "html", str)
    app.add_directive(NAME, Diagram)
    app.connect("html-page-context", _load_script)
    app.connect("build-finished", _copy_script)


def _load_script(
    app: Sphinx, _page: str, _template: str, _context: dict[str, Any], tree: nodes.document | None
) -> None:
    if app.config.mermaid and tree is not None and any(_CLASS in raw["classes"] for raw in tree.findall(nodes.raw)):
        app.add_js_file("mermaid.js")
        app.add_js_file("diagrams.js")


def _copy_script(app: Sphinx, error: Exception | None) -> None:
    if app.config.mermaid and error is None:
        shutil.copyfile(app.config.mermaid, Path(app.outdir, "_static", "mermaid.js"))
