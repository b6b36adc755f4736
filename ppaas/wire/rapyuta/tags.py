"""Tags: names that a robot gives to containers, nodes and interfaces, unique among all endpoints of its user.

Source: ``rce/util/name.py``.
"""

import re

from ppaas.errors import InvalidInput

MAX_TAG = 255
"""Longest tag [characters]."""

_TAG = re.compile(r"[A-Za-z]\w*", re.ASCII)


def check_tag(kind: str, tag: str) -> str:
    """Return a tag.

    Parameters
    ----------
    kind : str
        Field that contains it, for the error.
    tag : str

    Raises
    ------
    InvalidInput
        It is not a letter followed by letters, digits and underscores, or is too long.
    """
    if len(tag) > MAX_TAG or not _TAG.fullmatch(tag):
        raise InvalidInput(f"{kind} {tag[:64]!r} is not valid: write a letter, then letters, digits and underscores")
    return tag


def split_address(field: str, text: str) -> tuple[str, str]:
    """Return the tags of endpoint and interface in ``ENDPOINT/INTERFACE``.

    Raises
    ------
    InvalidInput
        The text does not consist of two tags.
    """
    endpoint, slash, interface = text.partition("/")
    if not slash:
        raise InvalidInput(f"{field} {text[:64]!r} is not valid: write ENDPOINT/INTERFACE")
    return check_tag(field, endpoint), check_tag(field, interface)
