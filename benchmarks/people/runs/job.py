"""Settings and result of a run of the people bench."""

from dataclasses import dataclass
from typing import Literal

import msgspec

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
