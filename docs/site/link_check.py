"""Check of a built site: each link within it has a target, and each anchor exists."""

import posixpath
import re
from collections.abc import Collection, Mapping
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LINKS = {"a": "href", "link": "href", "img": "src", "script": "src", "source": "src", "iframe": "src"}
"""Attribute with a link, by element."""


class _Page(HTMLParser):
    """Anchors and links of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Record what an element has."""
        given = dict(attrs)
        self.anchors |= {value for value in (given.get("id"), given.get("name")) if value}
        if link := given.get(LINKS.get(tag, "")):
            self.links.append(link)


def broken_links(site: Path) -> list[str]:
    """Return a line for each link within a site that leads nowhere, or leaves the folder of the site.

    Links to other sites are not checked.

    Parameters
    ----------
    site : Path
        Folder of the site.
    """
    files = {file.relative_to(site).as_posix(): file for file in sorted(site.rglob("*")) if file.is_file()}
    pages = {name: _Page(file.read_text(encoding="utf-8")) for name, file in files.items() if name.endswith(".html")}
    return [
        f"{name}: {link}: {fault}"
        for name, page in pages.items()
        for link in dict.fromkeys(page.links)
        if (fault := _fault(files, pages, name, link))
    ]


def _fault(files: Collection[str], pages: Mapping[str, _Page], name: str, link: str) -> str | None:
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return None
    if parts.path.startswith("/"):
        return "begins with /, so it would leave the path of a proxy"
    target = posixpath.normpath(posixpath.join(posixpath.dirname(name), unquote(parts.path))) if parts.path else name
    if target.startswith(".."):
        return "leaves the site"
    if target not in files:
        target = posixpath.normpath(f"{target}/index.html")
    if target not in files:
        return "no such file"
    anchor = unquote(parts.fragment)
    return "no such anchor" if anchor and target in pages and anchor not in pages[target].anchors else None


def unreachable_pages(site: Path) -> list[str]:
    """Return the pages of a site to which no links lead from the first page."""
    files = {file.relative_to(site).as_posix(): file for file in site.rglob("*.html")}
    links = {name: _Page(file.read_text(encoding="utf-8")).links for name, file in files.items()}
    reached, waiting = {"index.html"}, ["index.html"]
    while waiting:
        name = waiting.pop()
        paths = (urlsplit(link).path for link in links[name])
        targets = {posixpath.normpath(posixpath.join(posixpath.dirname(name), unquote(path))) for path in paths}
        found = targets & links.keys() - reached
        reached |= found
        waiting.extend(found)
    return sorted(links.keys() - reached)


def inline_scripts(site: Path) -> list[str]:
    """Return the pages with a script within the page, or a handler in an attribute."""
    inline = re.compile(r"<script(?![^>]*\bsrc=)|<[^>]*\son\w+=|href=\"javascript:")
    return [
        file.relative_to(site).as_posix()
        for file in sorted(site.rglob("*.html"))
        if inline.search(file.read_text(encoding="utf-8"))
    ]
