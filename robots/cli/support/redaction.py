"""Removes secrets from what leaves a computer: passwords in URLs, tokens, tickets, keys, and settings named so."""

import re
from collections.abc import Iterable
from typing import Any

REMOVED = "[removed]"
"""Text that replaces a secret."""

LEAST = 4
"""Shortest known secret that is searched for: a shorter one is part of common words [characters]."""

_NAMES = "pass(?:word|wd|phrase)?|token|secret|ticket|credential|authorization|cookie|private|api[_-]?key|signature"

_SECRET_NAME = re.compile(rf"(?:^|[^a-z])(?:{_NAMES}|key)s?(?:$|[^a-z])", re.IGNORECASE)
"""Names of members and variables whose values are secrets, such as ``PPAAS_TOKEN`` and ``admin_password``."""

_FILE_NAME = re.compile(r"(?:file|path|folder)s?$", re.IGNORECASE)
"""Names of members that say where a secret is, not what it is."""

_PATTERNS = [
    # Private keys in PEM, also in a string of JSON.
    (re.compile(r"-----BEGIN [A-Z ]*PRIVATE KEY-----.*?(?:-----END [A-Z ]*PRIVATE KEY-----|\Z)", re.DOTALL), REMOVED),
    # Users and passwords of URLs; a password may hold a slash or an @.
    (re.compile(r"(?<=://)[^\s\"'<>]*@"), f"{REMOVED}@"),
    # Headers.
    (re.compile(r"\b(Bearer|Basic|Digest)\s+[\w.~+/=:-]{4,}", re.IGNORECASE), rf"\1 {REMOVED}"),
    # Tokens of users, and tickets of machines.
    (re.compile(r"\bppaas(?:_|-join-)[\w-]{16,}"), REMOVED),
    # Tokens of identity providers: JSON Web Tokens, whose first part begins with a brace.
    (re.compile(r"\beyJ[\w-]{8,}(?:\.[\w-]*){2}"), REMOVED),
    # Options of commands: --password x.
    (re.compile(rf"(--(?:[\w-]*-)?(?:{_NAMES})(?:\s+|=))(?!\[removed)\S+", re.IGNORECASE), rf"\1{REMOVED}"),
    # Settings: ?token=x, "secret": "x", api_key: 'x', also where JSON is quoted in JSON.
    (
        re.compile(
            rf"((?:^|[^a-z])(?:{_NAMES})s?[\"'\\]*\s*[=:]\s*)"
            r"(?!\[removed)(?:\"(?:[^\"\\]|\\.)*\"|'[^']*'|\\\"[^\"]*\\\"|[^\s\"'\\&,;}]+)",
            re.IGNORECASE | re.MULTILINE,
        ),
        rf"\1{REMOVED}",
    ),
]


def is_secret_name(name: str) -> bool:
    """Return whether a member or a variable has the name of a secret, and not of a file with one."""
    return bool(_SECRET_NAME.search(name)) and not _FILE_NAME.search(name)


class Redaction:
    """Removes secrets from texts and from values of JSON.

    Parameters
    ----------
    known : iterable of str
        Secrets that are known, such as the token of the user: they are removed wherever they are.
    """

    def __init__(self, known: Iterable[str] = ()) -> None:
        self._known = sorted({each for each in known if len(each) >= LEAST}, key=len, reverse=True)

    def text(self, text: str) -> str:
        """Return a text without secrets."""
        for secret in self._known:
            text = text.replace(secret, REMOVED)
        for pattern, replacement in _PATTERNS:
            text = pattern.sub(replacement, text)
        return text

    def value(self, value: Any) -> Any:
        """Return a value of JSON without secrets; members with the name of a secret lose their texts."""
        match value:
            case str():
                return self.text(value)
            case list() | tuple():
                return [self.value(each) for each in value]
            case dict():
                return {name: self._member(name, each) for name, each in value.items()}
            case _:
                return value

    def _member(self, name: str, value: Any) -> Any:
        return REMOVED if value and isinstance(value, str) and is_secret_name(name) else self.value(value)
