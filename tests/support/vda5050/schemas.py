"""Checks of messages against the published JSON schemas of VDA 5050."""

import json
from functools import cache
from pathlib import Path

from jsonschema import Draft202012Validator, FormatChecker

from ppaas.wire.vda5050.topics import Version

SCHEMAS = Path(__file__).parent / "schemas"

FOLDERS = {Version.V3_0: "3.0.1-draft"}
"""Folders that are not named as the version is spelled."""


@cache
def validator(version: Version, topic: str) -> Draft202012Validator:
    """Return the validator of the messages of a topic."""
    schema = json.loads((SCHEMAS / FOLDERS.get(version, version.value) / f"{topic}.schema").read_text())
    return Draft202012Validator(schema, format_checker=FormatChecker())


def problems(version: Version, topic: str, payload: bytes) -> list[str]:
    """Return what a message violates of its schema."""
    errors = validator(version, topic).iter_errors(json.loads(payload))
    return [f"{'.'.join(map(str, error.absolute_path))}: {error.message}" for error in errors]
