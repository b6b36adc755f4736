"""Finding: what is right or wrong with a robot, in one sentence, and what to do."""

from typing import Literal

import msgspec

Level = Literal["ok", "warn", "error"]

LEVELS: tuple[Level, ...] = ("ok", "warn", "error")
"""Levels in the order of their weight; the index is the level of ``diagnostic_msgs/DiagnosticStatus``."""


class Finding(msgspec.Struct, frozen=True):
    """Finding of the diagnosis.

    Parameters
    ----------
    level : {"ok", "warn", "error"}
        ``error`` if the robot cannot drive with it.
    kind : str
        Name of the kind of finding, which does not change with its words: ``scan-missing``.
    text : str
        What is the matter, in one sentence.
    advice : str
        What to do next; empty if there is nothing to do.
    topic : str
        Topic that it is about; empty for none.
    """

    level: Level
    kind: str
    text: str
    advice: str = ""
    topic: str = ""


def ok(kind: str, text: str, advice: str = "", topic: str = "") -> Finding:
    """Return a note: nothing is wrong, but a reader may ask."""
    return Finding("ok", kind, text, advice, topic)


def warn(kind: str, text: str, advice: str = "", topic: str = "") -> Finding:
    """Return a warning: the robot drives, but not well."""
    return Finding("warn", kind, text, advice, topic)


def error(kind: str, text: str, advice: str = "", topic: str = "") -> Finding:
    """Return an error: the robot cannot drive."""
    return Finding("error", kind, text, advice, topic)


def worst(findings: list[Finding]) -> Level:
    """Return the highest level of findings; ``ok`` without any."""
    return max((finding.level for finding in findings), key=LEVELS.index, default="ok")
