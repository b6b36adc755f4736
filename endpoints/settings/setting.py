"""A setting, made from an option of a command: its key in files, its variable, its type."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints
from urllib.parse import urlsplit, urlunsplit

from ppaas.errors import PPaaSError

PREFIX = "PPAAS_"
"""Beginning of the names of all variables of this project."""

CONFIG = "config"
"""Name of the option for the file itself, which is no setting in it."""

URLS = frozenset({"store", "map_store"})
"""Settings that may contain a password in their variable, which the program removes from its environment."""

HIDDEN = "***"
"""Stands for a password where settings are shown."""

RELOADED: Mapping[str, frozenset[str]] = {
    "up": frozenset(
        {
            *("allow_origin", "idle", "keep_versions", "log_level", "max_connections", "max_connections_per_address"),
            *("metrics_robots", "quota", "retention", "retention_size", "trusted_proxy"),
            *("webhook_allow_http", "webhook_allow_private"),
            *("oidc_algorithm", "oidc_audience", "oidc_client_id", "oidc_client_secret_file", "oidc_cloud_url"),
            *("oidc_groups_claim", "oidc_issuer", "oidc_leeway", "oidc_name", "oidc_role", "oidc_scope"),
            *("oidc_session", "oidc_username_claim"),
        }
    )
}
"""Settings that a running command takes from its file again, by table; the others need a restart."""

_OTHER_VARIABLES = {"data": "PPAAS_DATA_FOLDER"}
"""Variables that are not named as their options: ``PPAAS_DATA`` is the folder of real data for tests and benches."""


@dataclass(frozen=True)
class Setting:
    """A setting of a command.

    Parameters
    ----------
    table : str
        Table of the command in a file.
    action : argparse.Action
        Option of the command.
    """

    table: str
    action: argparse.Action

    @property
    def flag(self) -> str:
        """Option, such as ``--map-store``."""
        return self.action.option_strings[-1]

    @property
    def name(self) -> str:
        """Name in the table, such as ``map-store``."""
        return self.flag.removeprefix("--")

    @property
    def key(self) -> str:
        """Name with the table, such as ``up.map-store``."""
        return f"{self.table}.{self.name}"

    @property
    def variable(self) -> str:
        """Environment variable, such as ``PPAAS_MAP_STORE``."""
        return _OTHER_VARIABLES.get(self.action.dest, f"{PREFIX}{self.action.dest.upper()}")

    @property
    def field(self) -> str:
        """Name of the field in the model, which pydantic-settings joins with the prefix to the variable."""
        return self.variable.removeprefix(PREFIX).lower()

    @property
    def reloads(self) -> bool:
        """Whether a running command takes a new value without a restart."""
        return self.action.dest in RELOADED.get(self.table, ())

    @property
    def help(self) -> str:
        """Help of the option, with its default."""
        return (self.action.help or "") % {**vars(self.action), "prog": "ppaas"}

    @property
    def type_name(self) -> str:
        """Type of the value in a file, in words."""
        form = self.form
        if get_origin(form) is Literal:
            return f"one of {', '.join(map(str, get_args(form)))}"
        if get_origin(form) is dict:
            return "table"
        if get_origin(form) is list:
            return "list of texts"
        return {int: "whole number", str: "text", bool: "true or false"}.get(form, "number")

    @property
    def form(self) -> Any:
        """Type of the value in a file: the return type of the option's parser, in the terms of TOML."""
        if self.action.const is not None:
            return bool
        if self.action.choices is not None:
            return Literal[tuple(self.action.choices)]
        result = _result_of(self.action.type)
        if get_origin(result) is tuple and self._is_list:
            return dict[str, _scalar(get_args(result)[1])]  # type: ignore[misc]
        return list[str] if self._is_list else _scalar(result)

    def from_file(self, value: Any) -> Any:
        """Return the option's value for a value of type ``form``; ``ValueError`` unless it is in the option's range."""
        if isinstance(value, bool):
            return self.action.const if value else self.action.default
        if isinstance(value, dict):
            return [self._parsed(f"{key}={_text(each)}") for key, each in value.items()]
        if isinstance(value, list):
            return [self._parsed(each) for each in value]
        if self.action.dest in URLS and _has_password(value):
            raise ValueError(f"a password must not be here: give {self.name}-file, a file with the URL")
        return self._parsed(_text(value))

    def from_text(self, text: str) -> Any:
        """Return the option's value for the text of a variable; ``ValueError`` if it is none."""
        if self.form is bool:
            if text not in ("true", "false"):
                raise ValueError("expected true or false")
            return self.from_file(text == "true")
        if self._is_list:
            return [self._parsed(each.strip()) for each in text.split(",")]
        if self.action.choices is not None and text not in self.action.choices:
            raise ValueError(f"expected {self.type_name}")
        return self._parsed(text)

    def shown(self, value: Any) -> Any:
        """Return a value as JSON has it, without its password."""
        if self.form is bool:
            return value is not None and value is not False
        if self.action.dest in URLS and value is not None:
            return without_password(value)
        if isinstance(value, list):
            return dict(value) if get_origin(self.form) is dict else value
        if isinstance(value, tuple):  # host and port
            return ":".join(map(str, value))
        return str(value) if isinstance(value, Path) else value

    @property
    def _is_list(self) -> bool:
        return isinstance(self.action.default, list)

    def _parsed(self, text: str) -> Any:
        parse: Callable[[str], Any] = self.action.type or str  # type: ignore[assignment]
        try:
            return parse(text)
        except (PPaaSError, argparse.ArgumentTypeError) as error:
            raise ValueError(str(error)) from error


def settings_of(tables: Mapping[str, Callable[[argparse.ArgumentParser], None]]) -> tuple[Setting, ...]:
    """Return the settings of commands, from the functions that add their options, by table."""
    found = []
    for table, configure in tables.items():
        parser = argparse.ArgumentParser(add_help=False)
        configure(parser)
        options = [action for action in parser._actions if action.option_strings and action.dest != CONFIG]
        found += [Setting(table, action) for action in options]
    return tuple(found)


def without_password(url: str) -> str:
    """Return a URL with its password hidden; a text that is no URL is hidden as a whole."""
    try:
        parts = urlsplit(url)
        if parts.password is None:
            return url
    except ValueError:
        return HIDDEN
    login, _, hosts = parts.netloc.rpartition("@")
    return urlunsplit(parts._replace(netloc=f"{login.partition(':')[0]}:{HIDDEN}@{hosts}"))


def _has_password(url: str) -> bool:
    return without_password(url) != url


def _result_of(parse: Any) -> Any:
    if parse is None or isinstance(parse, type):
        return parse or str
    return get_type_hints(parse)["return"]


def _scalar(kind: type) -> Any:
    return kind if kind in (int, float) else str


def _text(value: Any) -> str:
    """Return a value as the parser of an option reads it: pydantic makes floats of all numbers where one is allowed."""
    return str(int(value) if isinstance(value, float) and value.is_integer() else value)
