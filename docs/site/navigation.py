"""Navigation of the site: its sections, and the pages in each."""

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Section:
    """A section of the navigation.

    Parameters
    ----------
    title : str
        Its heading.
    pages : tuple of str
        Pages in order, by their paths in the site, without the suffix.
    """

    title: str
    pages: tuple[str, ...]


def read_navigation(file: Path) -> tuple[Section, ...]:
    """Return the sections that a file of TOML has."""
    read = tomllib.loads(file.read_text(encoding="utf-8"))
    return tuple(Section(each["title"], tuple(each["pages"])) for each in read["section"])


def sidebar(sections: Iterable[Section]) -> str:
    """Return the sections as tables of contents that only the sidebar shows, for the end of the first page."""
    trees = (
        "\n".join(["", "```{toctree}", ":hidden:", f":caption: {section.title}", "", *section.pages, "```", ""])
        for section in sections
    )
    return "".join(trees)
