"""Record of a run for its picture: tracks on floors, and what lifts did."""

from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.building.hotel.run import HotelCase, HouseRun
from ppaas.buildings.lifts.car import Car
from robots.pictures.figure_file import check_figure
from robots.pictures.lift_traces import FloorTracks, LiftTrace, write_lift_traces

PERIOD = 1.0
"""Time between two records [s]."""


class _Track(NamedTuple):
    """Part of the way of a robot, on one floor."""

    floor: str
    robot: int
    places: list[tuple[float, float]]


class RunRecord:
    """Watches a run.

    Attributes
    ----------
    times : list of float
        Times of the records [s].
    """

    def __init__(self) -> None:
        self.times: list[float] = []
        self._tracks: list[_Track] = []
        self._newest: dict[int, _Track] = {}
        self._lifts: defaultdict[str, list[tuple[int, str, list[tuple[int, int]]]]] = defaultdict(list)

    def watch(self, run: HouseRun, now: float) -> None:
        """Take where robots and cars are, once a period."""
        if self.times and now < self.times[-1] + PERIOD:
            return
        self.times.append(now)
        for number, robot in enumerate(run.robots.values()):
            if robot.disc is not None:
                self._extend(number, robot.floor, (robot.disc.pose.x, robot.disc.pose.y))
        floors, robots = list(run.floors), list(run.robots)
        for lift, car in run.site.runner.lifts.cars.items():
            aboard = [(ride.place, robots.index(ride.robot.partition("/")[2])) for ride in car.aboard]
            self._lifts[lift].append((*_state_of(car, floors), aboard))

    def _extend(self, robot: int, floor: str, place: tuple[float, float]) -> None:
        track = self._newest.get(robot)
        if track is None or track.floor != floor:
            track = self._newest[robot] = _Track(floor, robot, [])
            self._tracks.append(track)
        track.places.append(place)

    def write(self, path: Path, run: HouseRun) -> None:
        """Draw what was recorded of a run; raises as ``write_lift_traces``."""
        floors = [
            FloorTracks(
                name, grid, [(each.robot, np.array(each.places)) for each in self._tracks if each.floor == name]
            )
            for name, grid in run.house.grids.items()
        ]
        lifts = []
        for lift, trace in self._lifts.items():
            at, doors, riders = zip(*trace, strict=True)
            lifts.append(LiftTrace(lift, at, doors, riders))
        write_lift_traces(path, floors, self.times, lifts)


def _state_of(car: Car, floors: list[str]) -> tuple[int, str]:
    """Return the number of the floor where a car is, and its doors, or that it is out of order."""
    state = car.state
    if state is None or state.floor not in floors:
        return 0, "closed"
    return floors.index(state.floor), state.door if state.mode == "agv" else "offline"


def write_run(path: Path, case: HotelCase, seed: int) -> None:
    """Simulate a run, and draw it.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    check_figure(path)
    run, record = HouseRun(case, seed), RunRecord()
    run.run(record.watch)
    record.write(path, run)
