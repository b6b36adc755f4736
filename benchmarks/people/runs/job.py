"""Settings and result of a run of the people bench, and the file that keeps results."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput
from ppaas.maps.grid import GridMap

Policy = Literal["paper", "nearest", "single"]
POLICIES: tuple[Policy, ...] = ("paper", "nearest", "single")
"""The rule of the paper; the nearest robot at any time, without hysteresis; one robot that follows, always the same."""

Detections = Literal["camera", "laser", "truth"]
DETECTIONS: tuple[Detections, ...] = ("camera", "laser", "truth")
"""Depth images through the torso detector; scans through the leg detector; true positions with noise, in its place."""


@dataclass(frozen=True, slots=True)
class PeopleJob:
    """Settings of a run.

    Parameters
    ----------
    map : str
        Name of the map.
    grid : GridMap
    robots, people : int
        Numbers of robots and people.
    minutes : float
        Simulated time [min].
    policy : str
        One of `POLICIES`.
    detections : str
        One of `DETECTIONS`.
    size : tuple of int
        Width and height of depth images [pixels].
    seed : int
        All randomness depends on it alone.
    fault : str
        Name of the bad input that the run has; empty for none.
    """

    map: str
    grid: GridMap
    robots: int
    people: int
    minutes: float
    policy: Policy = "paper"
    detections: Detections = "camera"
    size: tuple[int, int] = (320, 240)
    seed: int = 0
    fault: str = ""


class PeopleResult(msgspec.Struct, frozen=True):
    """Result of a run.

    Parameters
    ----------
    map : str
    robots, people : int
    policy : str
    seed : int
    count_error_mean, count_exact, identity_switches, followed_fraction, handovers, flaps, contacts, seen, ghosts
        See `robots.demo.people_score.PeopleFigures`.
    hota, mota : float
        Of the identities, by TrackEval.
    simulated, taken : float
        Simulated time, and the time that the run took [s].
    cycle_p99 : float
        99th percentile of the time of a cycle of the coordinator [s].
    fault : str
    """

    map: str
    robots: int
    people: int
    policy: str
    seed: int
    count_error_mean: float
    count_exact: float
    identity_switches: int
    followed_fraction: float
    handovers: int
    flaps: int
    contacts: int
    seen: float
    ghosts: float
    hota: float
    mota: float
    simulated: float
    taken: float
    cycle_p99: float
    fault: str = ""


# -- results of runs in a file, so that an interrupted bench continues where it stopped --------------------------------


class Row(msgspec.Struct, frozen=True):
    """Line of the file: the key of a run and its result."""

    job: str
    result: PeopleResult


def read_results(path: Path) -> Mapping[str, PeopleResult]:
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


def check_results(path: Path) -> None:
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


def append_result(path: Path, job: PeopleJob, result: PeopleResult) -> None:
    """Append the result of a run; several processes may append at once, since each line is one write."""
    with path.open("ab") as file:
        file.write(msgspec.json.encode(Row(key_of(job), result)) + b"\n")


def key_of(job: PeopleJob) -> str:
    """Return the key of a run: all of its settings except the cells of the map."""
    settings = {field.name: getattr(job, field.name) for field in fields(job) if field.name != "grid"}
    return msgspec.json.encode(settings, order="deterministic").decode()
