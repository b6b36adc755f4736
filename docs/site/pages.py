"""Pages of the site: the Markdown files of the project, with their links adapted, and pages made from the code."""

import posixpath
import re
import shutil
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from urllib.parse import urlsplit

from docs.site.navigation import Section, sidebar
from docs.site.reference import (
    commands,
    examples,
    messages,
    nav2_parameters,
    parameters,
    rest,
    ros_parameters,
    schemas,
    settings,
    topics,
)
from ppaas.errors import InvalidInput

ROOT = Path(__file__).resolve().parents[2]

HOME = "index"
"""The first page of the site, which is the README of the project."""

GENERATED = {
    "reference/rest": rest.page,
    "reference/schemas": schemas.page,
    "reference/commands": commands.page,
    "reference/settings": settings.page,
    "reference/topics": topics.page,
    "reference/messages": messages.page,
    "reference/parameters": parameters.page,
    "reference/nav2-parameters": nav2_parameters.page,
    "reference/ros-parameters": ros_parameters.page,
    "reference/examples": examples.page,
}
"""Pages that are made from the code."""

_NOT_IN_THE_SIDEBAR = "---\norphan: true\n---\n\n"
"""Head of a decision, which the page of decisions lists: with all of them the sidebar would be long."""

_FENCE = re.compile(r"^(```.*?^```$)", re.MULTILINE | re.DOTALL)
_TARGET = re.compile(r"(?<=\]\()([^)\s]+)(?=\))")


def project_pages() -> dict[PurePosixPath, str]:
    """Return the Markdown files of the project that are pages, from its root, with their places in the site."""
    found = {"README.md": HOME, "findings/README.md": "findings/README"}
    found |= {f"{name}.md": name for name in ("CHANGELOG", "CONTRIBUTING", "SECURITY")}
    docs = ROOT / "docs"
    for file in sorted(set(docs.rglob("*.md")) - set(docs.glob("examples/*/README.md"))):  # packages, not pages
        found[file.relative_to(ROOT).as_posix()] = file.relative_to(docs).with_suffix("").as_posix()
    return {PurePosixPath(name): place for name, place in found.items()}


def lay_out(source: Path, navigation: Sequence[Section]) -> None:
    """Write all pages into a folder, for Sphinx.

    Parameters
    ----------
    source : Path
        Folder to make.
    navigation : sequence of Section
        Sections of the sidebar.

    Raises
    ------
    InvalidInput
        A link of a page names no file of the project.
    """
    pages = project_pages()
    shutil.copytree(ROOT / "docs" / "images", source / "images")
    faults: list[str] = []
    for name, place in pages.items():
        text = _with_site_links(name, place, pages, source, faults)
        if place == HOME:
            text += sidebar(navigation)
        if name.match("docs/adr/0*.md"):
            text = _NOT_IN_THE_SIDEBAR + text
        _write(source / f"{place}.md", text)
    if faults:
        raise InvalidInput("links that name no file:\n" + "\n".join(faults))
    for place, make in GENERATED.items():
        _write(source / f"{place}.md", make())
    for file in examples.files():
        _copy(file, source)


def _with_site_links(
    name: PurePosixPath, place: str, pages: dict[PurePosixPath, str], source: Path, faults: list[str]
) -> str:
    """Return the text of a page, with links for its place in the site; copy the files that it names."""

    def renamed(match: re.Match[str]) -> str:
        link = match[0]
        parts = urlsplit(link)
        if parts.scheme or not parts.path:
            return link
        target = PurePosixPath(posixpath.normpath(name.parent / parts.path))
        found = _in_site(target, pages)
        if found is None:
            faults.append(f"{name}: {link}")
            return link
        if target not in pages and (ROOT / target).is_file() and not found.startswith("images/"):
            _copy(target, source)
        path, _, anchor = found.partition("#")
        anchor = anchor or parts.fragment
        return posixpath.relpath(path, posixpath.dirname(place) or ".") + (f"#{anchor}" if anchor else "")

    text = (ROOT / name).read_text(encoding="utf-8")
    return "".join(part if part.startswith("```") else _TARGET.sub(renamed, part) for part in _FENCE.split(text))


def _in_site(target: PurePosixPath, pages: dict[PurePosixPath, str]) -> str | None:
    """Return the path in the site of a file or folder of the project, and perhaps an anchor; None if there is none."""
    if target in pages:
        return f"{pages[target]}.md"
    if not (ROOT / target).exists():
        return None
    if (ROOT / target).is_dir():
        return _folder(target, pages)
    if target.is_relative_to("docs/images"):
        return target.relative_to("docs").as_posix()
    return f"files/{target}"


def _folder(target: PurePosixPath, pages: dict[PurePosixPath, str]) -> str | None:
    """Return the page of a folder: its README, or its section among the examples."""
    if target / "README.md" in pages:
        return f"{pages[target / 'README.md']}.md"
    is_example = any(file.parent == target for file in examples.files())
    return f"reference/examples.md#{examples.anchor(target)}" if is_example else None


def _copy(file: PurePosixPath, source: Path) -> None:
    copy = source / "files" / file
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(ROOT / file, copy)


def _write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
