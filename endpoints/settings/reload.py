"""Settings of a running command, read again: what differs now, and which of it takes effect without a restart."""

import argparse
import json
from collections.abc import Callable, Collection
from typing import Any

import msgspec

from endpoints.settings.setting import Setting

REPORT = "reload.json"
"""File in the data folder of a cloud with the report of the last reload, for ``ppaas config reload``.

It exists from the start, with the id of the process: one of an earlier release would be ended by the signal."""


class ChangedSetting(msgspec.Struct, frozen=True):
    """A setting whose value is not the one with which the command runs.

    Parameters
    ----------
    key : str
        Key, such as ``up.quota``.
    before, after : str
        Values as a file of settings has them, without passwords.
    applied : bool
        Whether the new value is in force; otherwise it needs a restart.
    """

    key: str
    before: str
    after: str
    applied: bool


class ReloadReport(msgspec.Struct, frozen=True, kw_only=True):
    """What became of a reload.

    Parameters
    ----------
    pid : int
        Id of the process.
    began : float
        Time at which it began [s since the start of the host].
    file : str, optional
        File of settings that was read; None if there is none.
    changed : list of ChangedSetting
    problem : str
        Why nothing was changed, one fault a line; empty if the settings are good.
    """

    pid: int = 0
    began: float = 0.0
    file: str | None = None
    changed: list[ChangedSetting] = []
    problem: str = ""

    def __str__(self) -> str:
        applied = [one.key for one in self.changed if one.applied]
        waiting = [one.key for one in self.changed if not one.applied]
        parts = [f"changed: {', '.join(applied)}" if applied else "nothing has changed that could be applied"]
        if waiting:
            parts.append(f"needs a restart: {', '.join(waiting)}")
        return "; ".join(parts)


class RunningSettings:
    """Settings with which a command runs.

    Parameters
    ----------
    settings : collection of Setting
        Those of the command.
    read : callable
        Returns the settings that the command would take now; ``InvalidInput`` if one is wrong. It blocks.

    Attributes
    ----------
    arguments : Namespace
        Settings in force; `take` changes them.
    """

    def __init__(self, settings: Collection[Setting], read: Callable[[], argparse.Namespace]) -> None:
        self._settings = settings
        self._read = read
        self.arguments = read()
        self._running = vars(self.arguments).copy()  # the command may change its arguments

    def again(self) -> tuple[argparse.Namespace, ReloadReport]:
        """Read the settings again; return the arguments with the values that can be applied, and what differs.

        Nothing is changed before `take`. It blocks.

        Raises
        ------
        InvalidInput
            A setting is misspelt or wrong; the text has a line for each.
        """
        found = self._read()
        new = {each: getattr(found, each.action.dest) for each in self._settings}
        differing = {each: value for each, value in new.items() if value != self._running[each.action.dest]}
        taken = {each.action.dest: value for each, value in differing.items() if each.reloads}
        report = ReloadReport(
            file=None if found.config is None else str(found.config),
            changed=[
                ChangedSetting(each.key, _text(each, self._running[each.action.dest]), _text(each, value), each.reloads)
                for each, value in differing.items()
            ],
        )
        return argparse.Namespace(**vars(self.arguments) | taken), report

    def take(self, arguments: argparse.Namespace) -> None:
        """Put the arguments of `again` into force."""
        for each in self._settings:
            if each.reloads:
                self._running[each.action.dest] = getattr(arguments, each.action.dest)
        vars(self.arguments).update(vars(arguments))


def _text(setting: Setting, value: Any) -> str:
    shown = setting.shown(value)
    if shown is None:
        return "-"
    return shown if isinstance(shown, str) and shown else json.dumps(shown, ensure_ascii=False)
