"""Files of settings: TOML, with a table for each command."""

import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from endpoints.settings.names import did_you_mean
from endpoints.settings.setting import Setting
from ppaas.errors import InvalidInput

DEFAULT_FILE = Path("/etc/ppaas/ppaas.toml")
"""File of settings that is read, where it exists, if none is given."""

MAX_FILE = 65536
"""Largest size of a file of settings [bytes]."""


class SettingsFile:
    """Content of a file of settings.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    InvalidInput
        It cannot be read, is too large, or is no TOML; the text names the line.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with path.open("rb") as opened:
                content = opened.read(MAX_FILE + 1)
            if len(content) > MAX_FILE:
                raise InvalidInput(f"{path} is too large: a file of settings has at most {MAX_FILE} bytes")
            self._text = content.decode().replace("\r\n", "\n")
            self._content = tomllib.loads(self._text)
        except OSError as error:
            raise InvalidInput(f"cannot read the settings: {error}") from error
        except ValueError as error:  # of TOML, or of UTF-8
            raise InvalidInput(f"{path} is no TOML: {error}") from error

    def table(self, name: str) -> dict[str, Any]:
        """Return the values of a table by name; empty if there is none."""
        found = self._content.get(name, {})
        return found if isinstance(found, dict) else {}

    def unknown_keys(self, settings: Collection[Setting]) -> Iterator[str]:
        """Yield a sentence for each key that is no setting."""
        names: dict[str, set[str]] = {}
        for setting in settings:
            names.setdefault(setting.table, set()).add(setting.name)
        for table, content in self._content.items():
            if table not in names:
                yield f"{self.place(table)}: {table} is unknown{_advice(table, names)}"
            elif not isinstance(content, dict):
                yield f"{self.place(table)}: {table} must be a table"
            else:
                for name in sorted(content.keys() - names[table]):
                    yield f"{self.place(table, name)}: {table}.{name} is unknown{did_you_mean(name, names[table])}"

    def place(self, *key: str) -> str:
        """Return the file and the line of a key, such as ``/etc/ppaas/ppaas.toml:3``."""
        lines = self._text.split("\n")
        after = 0  # lines of the longest beginning of the file that is TOML and lacks the key
        for number in range(1, len(lines) + 1):
            try:
                found = _has(tomllib.loads("\n".join(lines[:number])), key)
            except tomllib.TOMLDecodeError:
                continue
            if found:
                break
            after = number
        return f"{self.path}:{after + 1}"


def _has(content: Any, key: tuple[str, ...]) -> bool:
    for name in key:
        if not isinstance(content, dict) or name not in content:
            return False
        content = content[name]
    return True


def _advice(table: str, names: Mapping[str, Collection[str]]) -> str:
    """Return what to write in the place of a table, or of a key outside of all tables."""
    owners = [f"{each}.{table}" for each in sorted(names) if table in names[each]]
    if owners:
        return f": write it in the table of its command, as {' or '.join(owners)}"
    return did_you_mean(table, names) or f"; the tables are {' and '.join(sorted(names))}"
