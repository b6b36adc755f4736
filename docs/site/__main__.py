"""``python -m docs.site``: build the documentation site."""

import argparse
import sys
from pathlib import Path

from docs.site.build import build
from docs.site.pages import ROOT
from ppaas.errors import PPaaSError

MERMAID = ROOT / "build" / "mermaid" / "node_modules" / "@mermaid-js" / "tiny" / "dist" / "mermaid.tiny.js"
"""Folder of the script that draws diagrams, which ``make docs`` installs."""


def main(words: list[str]) -> int:
    """Build the site; return the exit status."""
    parser = argparse.ArgumentParser("python -m docs.site", description="Build the documentation site.")
    parser.add_argument("folder", type=Path, help="folder of the site; one that is there is replaced")
    parser.add_argument(
        "--mermaid", type=Path, default=MERMAID, help="script that draws diagrams; without it they are shown as text"
    )
    arguments = parser.parse_args(words)
    try:
        pages = build(arguments.folder, mermaid=arguments.mermaid if arguments.mermaid.exists() else None)
    except PPaaSError as error:
        sys.stderr.write(f"docs: {error}\n")
        return 1
    sys.stdout.write(f"docs: {pages} pages in {arguments.folder}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
