"""Finding: what is right or wrong with a robot, in one sentence, and what to do; words and numbers for it."""

import difflib
from collections.abc import Iterable
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


MOST_NAMED = 12
"""Largest number of names that a sentence lists."""


def seconds(value: float) -> str:
    """Return a time [s] in words: ``0.4 s``, ``3 min``, ``5 h``, ``2 days``."""
    if value < 120.0:
        return f"{value:.1f} s"
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if value >= 2.0 * size:
            return f"{value / size:.0f} {unit}"
    return f"{value:.0f} s"


def size(value: float) -> str:
    """Return a number of bytes in words: ``800 bytes``, ``12 kB``, ``1.4 MB``."""
    if value < 1e3:
        return f"{value:.0f} bytes"
    return f"{value / 1e3:.0f} kB" if value < 1e6 else f"{value / 1e6:.1f} MB"


def hertz(value: float) -> str:
    """Return a rate in words: ``10 Hz``, ``0.4 Hz``."""
    return f"{value:.0f} Hz" if value >= 9.5 else f"{value:.1f} Hz"


def count(number: int, word: str) -> str:
    """Return a number of things: ``1 message``, ``30 messages``."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def percent(share: float) -> str:
    """Return a share in percent."""
    return f"{share * 100:.0f} %"


def names(found: Iterable[str]) -> str:
    """Return a list of names, cut after `MOST_NAMED`; ``none`` without any."""
    known = list(found)
    more = f" and {len(known) - MOST_NAMED} more" if len(known) > MOST_NAMED else ""
    return (", ".join(known[:MOST_NAMED]) or "none") + more


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the known name that a name may be a misspelling of; empty if none is near."""
    candidates = [each for each in known if each != name]
    last = {each.rpartition("/")[2]: each for each in candidates}
    if (same := last.get(name.rpartition("/")[2])) is not None:
        return same
    found = difflib.get_close_matches(name, candidates, 1, 0.5)
    return found[0] if found else ""


def capital(text: str) -> str:
    """Return a text as a sentence: with a capital letter, and a full stop at its end."""
    text = text[:1].upper() + text[1:]
    return text if text.endswith((".", "!", "?")) else f"{text}."
