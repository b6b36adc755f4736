"""Results of drives in a file, so that an interrupted bench continues where it stopped."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from benchmarks.navigation.goals.run import GoalsJob, GoalsResult
from ppaas.errors import InvalidInput


def read(path: Path) -> Mapping[str, list[GoalsResult]]:
    """Return the stored results by `key`; empty if the file does not exist.

    Raises
    ------
    InvalidInput
        The file cannot be read, or its content is invalid.
    """
    try:
        lines = path.read_text().splitlines() if path.exists() else []
        rows = [json.loads(line) for line in lines]
        return {row["job"]: [GoalsResult(**each) for each in row["results"]] for row in rows}
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InvalidInput(f"{path} is not a file of 'ppaas bench goals --keep': {error}; name another file") from error


def append(path: Path, job: GoalsJob, results: list[GoalsResult]) -> None:
    """Append the results of a drive; several processes may append at once, since each line is one write."""
    line = json.dumps({"job": key(job), "results": [asdict(result) for result in results]})
    with path.open("a") as file:
        file.write(line + "\n")


def key(job: GoalsJob) -> str:
    """Return the key of a drive: all of its settings except the cells of the map."""
    told = (job.name, job.people, job.goals, job.controller, job.parameters, job.seed, job.drive, job.told)
    return json.dumps(told, sort_keys=True)
