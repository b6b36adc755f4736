"""What came of drives, kept in a file: a long table is driven in parts, and goes on where it was broken off."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from benchmarks.navigation.goals.run import GoalsJob, GoalsResult
from ppaas.errors import InvalidInput


def read(path: Path) -> Mapping[str, list[GoalsResult]]:
    """Return what is kept, by `key`; nothing if there is no such file yet.

    Raises
    ------
    InvalidInput
        It holds something else, or cannot be read.
    """
    try:
        lines = path.read_text().splitlines() if path.exists() else []
        rows = [json.loads(line) for line in lines]
        return {row["job"]: [GoalsResult(**each) for each in row["results"]] for row in rows}
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InvalidInput(f"{path} does not hold what came of drives: {error}; name another file") from error


def append(path: Path, job: GoalsJob, results: list[GoalsResult]) -> None:
    """Add what came of a drive; several processes may do so at a time, since a line is one write."""
    line = json.dumps({"job": key(job), "results": [asdict(result) for result in results]})
    with path.open("a") as file:
        file.write(line + "\n")


def key(job: GoalsJob) -> str:
    """Return what says which drive this is: all but the cells of its map."""
    told = (job.name, job.people, job.goals, job.controller, job.parameters, job.seed, job.drive, job.told)
    return json.dumps(told, sort_keys=True)
