"""Options of the demos, and the cloud that they use."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from ppaas.maps.grid import GridMap

Write = Callable[[str], None]
"""Writes a line of text."""

CORES = 0.5
"""Size of a robot's container [CPU cores]; it is idle between scans."""


def no_lines(_line: str) -> None:
    """Write nothing."""


@dataclass(frozen=True, slots=True)
class DemoOptions:
    """Options of the demo.

    Parameters
    ----------
    robots, goals : int
        Number of robots, and of goals per robot.
    seed : int
        Seed of the courses, of the world's noise, and of the generated warehouse.
    map : tuple of str and GridMap, optional
        Id of a map, and the map; by default one is generated.
    keep_going : bool
        Repeat the courses until interrupted.
    write : callable
        Writes a line of progress; none is written by default.
    console : Console, optional
        Terminal for the table of progress, in place of the lines of single robots; none by default.
    planner, controller : str
        Move Base's global and local planner.
    explorers : int
        Number of robots that explore, in the demo of mapping.
    people : int
        Number of people, in the demo of people.
    seconds : float
        Time that is scored, in the demo of people [s].
    on_robot : bool
        Whether detectors of people run on the robots, instead of in the cloud.
    sensor : str
        Sensor that detects people: ``camera`` or ``laser``.
    traffic : bool
        Whether the robots take part in the traffic of the map.
    lift_users : int
        Number of people who use the lifts, in the demo of a building.
    picture : Path, optional
        PNG file for a picture of the run, in the demo of a building.
    """

    robots: int = 3
    goals: int = 2
    seed: int = 0
    map: "tuple[str, GridMap] | None" = None
    keep_going: bool = False
    write: Write = no_lines
    console: "Console | None" = None
    planner: str = "dijkstra"
    controller: str = "dwa"
    explorers: int = 1
    people: int = 5
    seconds: float = 60.0
    on_robot: bool = True
    sensor: str = "camera"
    traffic: bool = False
    lift_users: int = 0
    picture: Path | None = None


@dataclass(frozen=True, slots=True)
class CloudAccess:
    """URL of a cloud, and the name and password of an administrator."""

    url: str
    admin: str
    password: str
