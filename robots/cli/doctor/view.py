"""View of a diagnosis as text: findings in words, then a table of the topics."""

import textwrap
from collections import Counter
from typing import Any

from ppaas.diagnosis.rules.finding import hertz, seconds, size
from robots.cli.output import printable, table

WIDTH = 100
"""Width of a line [characters]."""

MARKS = {"error": "ERROR", "warn": "WARN", "ok": "OK"}
COLUMNS = ("topic", "type", "rate", "size", "data", "last", "late", "refused")
INDENT = 7


def as_text(report: dict[str, Any]) -> str:
    """Return a diagnosis of a robot or of a cloud as text."""
    lines = [_heading(report), ""]
    for finding in report["findings"]:
        lines += _finding(finding)
    if not report["findings"]:
        lines.append("OK     Everything that the cloud checks is in order.")
    if report.get("topics") and report.get("connected"):
        lines += ["", *table([_row(topic) for topic in report["topics"]], COLUMNS)]
    if report.get("frames"):
        lines += ["", *_wrapped(f"frames: {_frames(report['frames'])}", "")]
    return "\n".join(lines) + "\n"


def _heading(report: dict[str, Any]) -> str:
    counts = Counter(finding["level"] for finding in report["findings"])
    found = [_count(counts[level], word) for level, word in (("error", "error"), ("warn", "warning")) if counts[level]]
    name = report["robot"] if "robot" in report else f"cloud {report['cloud']}"
    watched = f" (watched for {report['seconds']:.1f} s)" if report.get("seconds") else ""
    return printable(f"{name}: {', '.join(found) or 'all is well'}{watched}")


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"


def _finding(finding: dict[str, Any]) -> list[str]:
    lines = _wrapped(finding["text"], f"{MARKS[finding['level']]:<{INDENT}}")
    return [*lines, *_wrapped(finding["advice"], " " * INDENT + "→ ")] if finding["advice"] else lines


def _wrapped(text: str, first: str) -> list[str]:
    return textwrap.wrap(printable(text), WIDTH, initial_indent=first, subsequent_indent=" " * len(first))


def _row(topic: dict[str, Any]) -> dict[str, Any]:
    came = topic["silence"] is not None
    return {
        "topic": topic["name"],
        "type": topic["type"] or None,
        "rate": hertz(topic["rate"]) if came else None,
        "size": size(topic["size"]) if topic["size"] else None,
        "data": f"{size(topic['bandwidth'])}/s" if topic["bandwidth"] else None,
        "last": f"{seconds(topic['silence'])} ago" if came else "never",
        "late": None if topic["late"] is None else seconds(topic["late"]),
        "refused": topic["refused"] or None,
    }


def _frames(frames: list[dict[str, Any]]) -> str:
    return ", ".join(f"{each['parent']} → {each['name']}{' (static)' if each['static'] else ''}" for each in frames)
