"""Effective values of settings, each with its source: a variable goes before the file, the file before the default."""

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any

from endpoints.settings.names import CONFIG_VARIABLE, own_variables, unknown_variables
from endpoints.settings.setting import Setting, settings_of
from endpoints.settings.toml_file import DEFAULT_FILE, SettingsFile
from ppaas.errors import InvalidInput


class Origin(IntEnum):
    """Where a value comes from, strongest first."""

    FLAG = 0
    VARIABLE = 1
    FILE = 2
    DEFAULT = 3


@dataclass(frozen=True)
class EffectiveValue:
    """Value of a setting.

    Parameters
    ----------
    setting : Setting
    value : object
        As the parser of the option returns it.
    origin : Origin
    source : str
        Where it comes from, in words, such as the file and the line.
    """

    setting: Setting
    value: Any
    origin: Origin
    source: str


class SettingsTree:
    """Settings of all commands, from the environment and a file.

    Parameters
    ----------
    tables : mapping
        Functions that add the options of the commands, by the name of their table.
    path : Path, optional
        File of settings; by default the one that the environment names, or the usual one if it exists.
    environment : mapping of str to str, optional
        Environment; by default the one that this process has now.

    Raises
    ------
    InvalidInput
        The file cannot be read.
    """

    def __init__(
        self,
        tables: Mapping[str, Callable[..., None]],
        path: Path | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self.settings = settings_of(tables)
        self.variables = own_variables(os.environ if environment is None else environment)
        path = path or _usual_file(self.variables)
        self.file = None if path is None else SettingsFile(path)

    def misspelt(self) -> list[str]:
        """Return a sentence for each variable and each key of the file that is unknown."""
        keys = () if self.file is None else self.file.unknown_keys(self.settings)
        return [*unknown_variables(self.variables, self.settings), *keys]

    def values(
        self, table: str, given: Mapping[str, Any] | None = None
    ) -> tuple[dict[Setting, EffectiveValue], list[str]]:
        """Return the values of a table, and a sentence for each one that is wrong.

        Parameters
        ----------
        table : str
        given : mapping
            Values of options on the command line, by their ``dest``.
        """
        flags = given or {}
        settings = [setting for setting in self.settings if setting.table == table]
        content = {} if self.file is None else self.file.table(table)
        found: dict[Setting, Any] = {}
        faults: dict[Setting, str] = {}
        if content or any(setting.variable in self.variables for setting in settings):
            # Imported here: the process of the master does not import pydantic unless it needs it.
            from endpoints.settings.model import read_values  # noqa: PLC0415

            found, faults = read_values(settings, content, self.variables)
        found |= {setting: flags[setting.action.dest] for setting in settings if setting.action.dest in flags}
        values = {
            setting: EffectiveValue(setting, found.get(setting, setting.action.default), *self._origin(setting, flags))
            for setting in settings
        }
        # An option hides a wrong value of a weaker source, but does not correct it.
        wrong = [f"{self._origin(setting, {})[1]}: {setting.key}: {words}" for setting, words in faults.items()]
        return values, [*wrong, *_settle_pairs(values)]

    def _origin(self, setting: Setting, flags: Mapping[str, Any]) -> tuple[Origin, str]:
        if setting.action.dest in flags:
            return Origin.FLAG, setting.flag
        if setting.variable in self.variables:
            return Origin.VARIABLE, setting.variable
        if self.file is not None and setting.name in self.file.table(setting.table):
            return Origin.FILE, self.file.place(setting.table, setting.name)
        return Origin.DEFAULT, "default"


def raise_if_any(problems: list[str]) -> None:
    """Raise ``InvalidInput`` with all problems, each in a line, if there are any."""
    if problems:
        raise InvalidInput("\n".join(problems))


def _usual_file(variables: Mapping[str, str]) -> Path | None:
    if CONFIG_VARIABLE in variables:
        return Path(variables[CONFIG_VARIABLE])
    try:
        DEFAULT_FILE.stat()
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError:
        return DEFAULT_FILE  # reading it reports why it cannot be read
    return DEFAULT_FILE


def _settle_pairs(values: dict[Setting, EffectiveValue]) -> Iterator[str]:
    """Keep the stronger of the URL of a store and the file with this URL; yield a sentence if both are as strong."""
    by_name = {setting.name: each for setting, each in values.items()}
    for each in list(by_name.values()):
        other = by_name.get(f"{each.setting.name}-file")
        if other is None or Origin.DEFAULT in (each.origin, other.origin):
            continue
        if each.origin != other.origin:
            weaker = max(each, other, key=lambda one: one.origin).setting
            values[weaker] = EffectiveValue(weaker, weaker.action.default, Origin.DEFAULT, "default")
        elif each.origin != Origin.FLAG:  # the command reports its options itself
            yield f"{each.source} and {other.source}: give either {each.setting.key} or {other.setting.key}"
