"""Software bills of materials (CycloneDX): completed, validated, and compared with the locked versions."""

import json
import uuid
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from ppaas.errors import InvalidInput

NAMESPACE = uuid.UUID("1f0cf3a0-5e0c-5d5b-9d5c-8a4b7a1f4f55")
"""Of the numbers of bills, each made from the subject of the bill."""


class Expected(NamedTuple):
    """Packages that a bill must list.

    Parameters
    ----------
    locked : dict
        Locked versions of Python's packages by their names; not all need be there.
    own : dict
        Versions of packages that no lock has: this project's own.
    kinds : tuple of str
        Kinds of packages, such as ``deb``.
    """

    locked: dict[str, str]
    own: dict[str, str]
    kinds: tuple[str, ...]


def dated(bill: dict[str, Any], subject: str, date: int) -> dict[str, Any]:
    """Return a bill with a number and a time that are the same in each build.

    Parameters
    ----------
    bill : dict
        It is not changed.
    subject : str
        What it is a bill of: the digest of an image.
    date : int
        Time of the build [s since 1970].
    """
    time = datetime.fromtimestamp(date, UTC).isoformat().replace("+00:00", "Z")
    number = uuid.uuid5(NAMESPACE, subject)
    return bill | {"serialNumber": f"urn:uuid:{number}", "metadata": bill.get("metadata", {}) | {"timestamp": time}}


def components(bill: dict[str, Any], kind: str) -> dict[str, str]:
    """Return the versions of all components of one kind, such as ``pypi`` or ``deb``, by their names."""
    return {
        found["name"]: found.get("version", "")
        for found in bill.get("components", ())
        if found.get("purl", "").startswith(f"pkg:{kind}/")
    }


def pins(lock: str) -> dict[str, str]:
    """Return the versions of a lock by the normal names of their packages, those for other computers left out."""
    lines = (line.removesuffix("\\").strip() for line in lock.splitlines() if line[:1].isalnum())
    found = (Requirement(line) for line in lines)
    return {
        canonicalize_name(pin.name): next(iter(pin.specifier)).version
        for pin in found
        if pin.marker is None or pin.marker.evaluate()
    }


def faults(bill: dict[str, Any], expected: Expected) -> Iterator[str]:
    """Yield what is wrong with a bill, as read from JSON."""
    version = SchemaVersion.from_version(str(bill.get("specVersion")))
    invalid = JsonStrictValidator(version).validate_str(json.dumps(bill))
    if invalid is not None:
        yield f"it does not fit the schema of CycloneDX {version.to_version()}: {invalid}"
    for kind in expected.kinds:
        if not components(bill, kind):
            yield f"it has no package of the kind {kind}"
    for name, found in components(bill, "pypi").items():
        wanted = (expected.own | expected.locked).get(canonicalize_name(name))
        if wanted is not None and found != wanted:
            yield f"{name} is {found}, not {wanted} as locked"
    named = {canonicalize_name(name) for name in components(bill, "pypi")}
    yield from (f"{name} {version} is not in it" for name, version in expected.own.items() if name not in named)


def complete(file: Path, subject: str, date: int, expected: Expected) -> int:
    """Give a bill its number and time, check it, and write it again; return how many components it has.

    Raises
    ------
    InvalidInput
        It fits no schema, has other versions than the lock, or lacks a kind of packages; all reasons are given.
    """
    bill = dated(json.loads(file.read_bytes()), subject, date)
    found = list(faults(bill, expected))
    if found:
        raise InvalidInput(f"{file.name}: {'; '.join(found)}")
    file.write_text(json.dumps(bill, indent=2, sort_keys=True) + "\n", encoding="utf-8")
    return len(bill["components"])
