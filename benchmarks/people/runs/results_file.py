"""Results of runs in a file, so that an interrupted bench continues where it stopped."""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path

import msgspec

from benchmarks.people.runs.job import PeopleJob, PeopleResult
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput


class Row(msgspec.Struct, frozen=True):
    """Line of the file: the key of a run and its result."""

    job: str
    result: PeopleResult


def read(path: Path) -> Mapping[str, PeopleResult]:
    """Return the stored results by `key`; empty if the file does not exist.

    Raises
    ------
    InvalidInput
        The file cannot be read, or its content is invalid.
    """
    try:
        lines = path.read_bytes().splitlines() if path.exists() else []
        rows = [from_json(line, Row) for line in lines]
    except (OSError, msgspec.MsgspecError) as error:
        text = f"{path} is not a file of 'ppaas bench people --keep': {error}; name another file"
        raise InvalidInput(text) from error
    return {row.job: row.result for row in rows}


def check(path: Path) -> None:
    """Create the file if it does not exist.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    try:
        path.open("ab").close()
    except OSError as error:
        raise InvalidInput(f"cannot write results to {path}: {error.strerror}; name another file") from error


def append(path: Path, job: PeopleJob, result: PeopleResult) -> None:
    """Append the result of a run; several processes may append at once, since each line is one write."""
    with path.open("ab") as file:
        file.write(msgspec.json.encode(Row(key(job), result)) + b"\n")


def key(job: PeopleJob) -> str:
    """Return the key of a run: all of its settings except the cells of the map."""
    settings = {field.name: getattr(job, field.name) for field in fields(job) if field.name != "grid"}
    return msgspec.json.encode(settings, order="deterministic").decode()
