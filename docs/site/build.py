"""Builds the site: lays out the pages, has Sphinx make HTML of them, and checks all links."""

import io
import re
import shutil
import tempfile
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.docutils import docutils_namespace, patch_docutils

from docs.site.link_check import broken_links, inline_scripts, unreachable_pages
from docs.site.navigation import read_navigation
from docs.site.pages import lay_out
from ppaas.errors import InvalidInput

HERE = Path(__file__).parent

_COLOUR = re.compile(r"\x1b\[[\d;]*m")


def build(folder: Path, *, mermaid: Path | None) -> int:
    """Build the site; return the number of its pages.

    Parameters
    ----------
    folder : Path
        Folder of the site. It is replaced as a whole, once all is well.
    mermaid : Path, optional
        Script that draws diagrams; without it they are shown as text.

    Raises
    ------
    InvalidInput
        A page has a fault, such as a broken link; the text lists all.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".docs-") as temporary:
        source, made = Path(temporary, "source"), Path(temporary, "site")
        lay_out(source, read_navigation(HERE / "navigation.toml"))
        faults = _make_html(source, made, Path(temporary, "doctrees"), mermaid) + broken_links(made)
        faults += [f"{page}: no link leads here" for page in unreachable_pages(made)]
        faults += [f"{page}: has a script within the page, which the cloud forbids" for page in inline_scripts(made)]
        if faults:
            raise InvalidInput("the site has faults:\n" + "\n".join(faults))
        if folder.exists():
            shutil.rmtree(folder)
        made.rename(folder)
    return len(list(folder.rglob("*.html")))


def _make_html(source: Path, made: Path, doctrees: Path, mermaid: Path | None) -> list[str]:
    """Have Sphinx make HTML; return its warnings, each with the page as it lies in the project."""
    warnings = io.StringIO()
    with patch_docutils(HERE), docutils_namespace():  # what one build registers, the next in this process must not find
        app = Sphinx(
            srcdir=source,
            confdir=HERE,
            outdir=made,
            doctreedir=doctrees,
            buildername="html",
            confoverrides={"mermaid": str(mermaid or "")},
            status=None,
            warning=warnings,
            parallel=2,
        )
        app.build()
    return [line.removeprefix(f"{source}/") for line in _COLOUR.sub("", warnings.getvalue()).splitlines()]
