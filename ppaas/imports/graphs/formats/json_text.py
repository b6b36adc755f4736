"""JSON as people's tools write it: with a byte-order mark, trailing commas and numbers that are none."""

import json
import re
from typing import Any

import msgspec

from ppaas.errors import InvalidInput
from ppaas.imports.report import ImportReport

_TRAILING = re.compile(r'("(?:[^"\\]|\\.)*")|,(?=\s*[\]}])')
"""A text of JSON, which is kept, or a comma before the end of an object or a list."""


def lenient_json(content: bytes, report: ImportReport) -> dict[str, Any]:
    """Return the object in a file of JSON; what is not JSON in it is noted in the report.

    Raises
    ------
    InvalidInput
        It is no JSON, or no object; the text has the place.
    """
    try:
        tree = msgspec.json.decode(content)
    except RecursionError as error:
        raise InvalidInput(f"{report.source} is nested too deeply") from error
    except (msgspec.DecodeError, UnicodeDecodeError):
        tree = _repaired(content, report)
    if not isinstance(tree, dict):
        raise InvalidInput(f"{report.source} is JSON, but no object: a graph is an object with nodes and edges")
    return tree


def _repaired(content: bytes, report: ImportReport) -> Any:
    try:
        text = content.decode(json.detect_encoding(content)).removeprefix("\ufeff")
        plain = _TRAILING.sub(lambda found: found[1] or "", text)
        commas = text.count(",") - plain.count(",")
        constants: list[str] = []
        tree = json.loads(plain, parse_constant=constants.append)
    except UnicodeDecodeError as error:
        raise InvalidInput(f"{report.source} is no text in UTF-8: {error.reason}") from error
    except RecursionError as error:
        raise InvalidInput(f"{report.source} is nested too deeply") from error
    except json.JSONDecodeError as error:
        raise InvalidInput(
            f"{report.source} is no JSON: {error.msg} in line {error.lineno}, column {error.colno}"
        ) from error
    if commas:
        report.translated("file", f"{commas} trailing commas, which are not JSON, were left out")
    if constants:
        report.translated("file", f"numbers such as {constants[0]}, which are not JSON, were read as null")
    return tree
