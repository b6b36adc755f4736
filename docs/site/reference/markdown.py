"""Markdown, written by programs."""

import re
from collections.abc import Iterable, Sequence


def code(text: str) -> str:
    """Return text as code."""
    return f"`{text}`" if text else ""


def cell(text: str) -> str:
    """Return text for a cell of a table: on one line, without the characters that end a cell."""
    return re.sub(r"\s+", " ", text).strip().replace("\\|", "|").replace("|", "\\|")


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; empty text if there are no rows."""
    lines = [f"| {' | '.join(cell(each) for each in row)} |" for row in rows]
    if not lines:
        return ""
    return "\n".join([f"| {' | '.join(header)} |", "|" + "---|" * len(header), *lines, ""])


def slug(heading: str) -> str:
    """Return the anchor of a heading, as GitHub and MyST make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def page(*parts: str) -> str:
    """Return a page of its parts; empty ones are left out."""
    return "\n\n".join(part.strip() for part in parts if part) + "\n"
