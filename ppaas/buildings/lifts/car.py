"""Car of a lift: its last report, and the robots that ride in it or wait for it."""

from collections.abc import Collection
from dataclasses import dataclass, field

from ppaas.buildings.lifts.schedule import Shaft
from ppaas.buildings.lifts.states import LiftOrder, LiftRide, LiftState, RemoveRide, StoreRide

SILENT = 5.0
"""Age of the last state of a lift from which it counts as silent [s]."""

SETTLED = 0.5
"""Time for which doors stay open before a robot passes them [s]; states of worn contacts flap."""


@dataclass(slots=True)
class CarTimes:
    """Times that are not stored [s since the epoch]; a controller that was restored counts them from its start.

    Parameters
    ----------
    began : float
        When the controller began.
    heard : float
        When the lift reported last.
    progress : float
        When the car moved, or a robot passed its doors.
    mode : float
        When the mode of the lift changed.
    opened : float, optional
        Since when the doors are open at a floor.
    doorway, lost : dict of str to float
        Since when robots are in the doorway, and not connected.
    """

    began: float
    heard: float
    progress: float
    mode: float
    opened: float | None = None
    doorway: dict[str, float] = field(default_factory=dict)
    lost: dict[str, float] = field(default_factory=dict)


class Car:
    """Car with its rides.

    Parameters
    ----------
    shaft : Shaft
    session : str
        Name of its sessions: the same after a restart, so that a session that was left open is ended.
    now : float
        Time [s since the epoch], as everywhere here.

    Attributes
    ----------
    rides : dict of str to LiftRide
        Rides by robot.
    state : LiftState, optional
        What the lift reported last.
    times : CarTimes
    """

    def __init__(self, shaft: Shaft, session: str, now: float) -> None:
        self.shaft, self.session = shaft, session
        self.rides: dict[str, LiftRide] = {}
        self.state: LiftState | None = None
        self.times = CarTimes(began=now, heard=float("-inf"), progress=now, mode=now)

    # -- events --------------------------------------------------------------------------------------------------------

    def see(self, state: LiftState, now: float) -> None:
        """Note what the lift reports."""
        before, times, silent = self.state, self.times, self.is_silent(now)
        self.state, times.heard = state, now
        if before is None or before.mode != state.mode:
            times.mode = now
        moved = before is not None and before.floor != state.floor
        is_other = before is None or (before.mode, before.session) != (state.mode, state.session)
        if moved or is_other or state.motion != "stopped":
            times.progress = now
        if state.door != "open" or state.motion != "stopped" or state.floor not in self.shaft.levels:
            times.opened = None
        elif times.opened is None or moved or silent:
            times.opened = now

    def let_go(self) -> None:
        """Note that the session was ended: doors that are still open count as open from the next state on."""
        self.times.opened = None

    def put(self, ride: LiftRide, now: float) -> list[LiftOrder]:
        """Add or change a ride, and have it stored."""
        before = self.rides.get(ride.robot)
        if before == ride:
            return []
        if not self.rides or (before is not None and before.phase != ride.phase):
            self.times.progress = now
        if before is None or before.phase != ride.phase:
            self.times.doorway.pop(ride.robot, None)
        self.rides[ride.robot] = ride
        if ride.is_in_doorway:
            self.times.doorway.setdefault(ride.robot, now)
        return [StoreRide(ride)]

    def end(self, robot: str, now: float) -> list[LiftOrder]:
        """End a ride."""
        if self.rides.pop(robot, None) is None:
            return []
        self.times.doorway.pop(robot, None)
        self.times.lost.pop(robot, None)
        self.times.progress = now
        return [RemoveRide(robot)]

    def see_robots(self, robots: Collection[str], now: float) -> None:
        """Note the robots that are connected."""
        lost = self.times.lost
        self.times.lost = {robot: lost.get(robot, now) for robot in self.rides if robot not in robots}

    # -- what is known -------------------------------------------------------------------------------------------------

    @property
    def lift(self) -> str:
        """Id of the lift."""
        return self.shaft.settings.lift

    @property
    def at(self) -> str:
        """Floor where the car is or was last; any floor if that is not known."""
        known = self.state is not None and self.state.floor in self.shaft.levels
        return self.state.floor if self.state is not None and known else next(iter(self.shaft.levels))

    @property
    def aboard(self) -> list[LiftRide]:
        """Rides whose robots take room in the car."""
        return [ride for ride in self.rides.values() if ride.is_aboard]

    @property
    def in_doorway(self) -> list[LiftRide]:
        """Rides whose robots may be between the doors."""
        return [ride for ride in self.rides.values() if ride.is_in_doorway]

    @property
    def waiting(self) -> list[LiftRide]:
        """Rides whose robots wait before a door."""
        return [ride for ride in self.rides.values() if ride.phase == "waiting"]

    @property
    def inside(self) -> list[LiftRide]:
        """Rides whose robots are in the car."""
        return [ride for ride in self.rides.values() if ride.phase == "inside"]

    def free_place(self, size: int) -> int:
        """Return the first of some places side by side in the car that nobody has; 0 if there are none."""
        taken = {place for ride in self.aboard for place in range(ride.place, ride.place + ride.size)}
        last = self.shaft.settings.robots - size
        return next((place for place in range(last + 1) if taken.isdisjoint(range(place, place + size))), 0)

    def is_silent(self, now: float) -> bool:
        """Return whether the lift has reported nothing for a while."""
        return self.state is None or now - self.times.heard > SILENT

    def is_new(self, now: float) -> bool:
        """Return whether the lift has not reported yet, and could not have been expected to."""
        return self.state is None and now - self.times.began <= SILENT

    def serves(self, floor: str, now: float) -> bool:
        """Return whether robots get to the lift at a floor, sooner or later; people who have it leave it again."""
        if floor not in self.shaft.levels or self.state is None or self.is_silent(now) or self.is_out_of_order(now):
            return False
        return not self.state.floors or floor in self.state.floors

    def is_held(self, now: float) -> bool:
        """Return whether the lift obeys the session."""
        state = self.state
        return state is not None and not self.is_silent(now) and state.mode == "agv" and state.session == self.session

    def is_unsafe(self, now: float) -> bool:
        """Return whether robots leave the car wherever its doors open."""
        return self.state is not None and not self.is_silent(now) and self.state.mode in ("fire", "emergency")

    def is_out_of_order(self, now: float) -> bool:
        """Return whether the lift reports a mode in which it serves nobody."""
        return self.state is not None and not self.is_silent(now) and self.state.mode not in ("agv", "human")

    def is_taken(self) -> bool:
        """Return whether people, or another controller, have the lift."""
        state = self.state
        return state is not None and (state.mode == "human" or state.session not in ("", self.session))

    def open_at(self, now: float) -> str:
        """Return the floor at which the doors have been open for a while; empty if they have not."""
        opened = self.times.opened
        if self.state is None or self.is_silent(now) or opened is None or now - opened < SETTLED:
            return ""
        return self.state.floor

    def fault(self, now: float) -> str:
        """Return why the lift does not serve robots now; empty if it does."""
        disorder, state = self.disorder(now), self.state
        if not disorder and state is not None and state.session not in ("", self.session):
            return f"lift {self.lift!r} is in use by {state.session!r}"
        return disorder

    def disorder(self, now: float) -> str:
        """Return why the lift serves nobody now; empty if it does."""
        if self.state is None or self.is_silent(now):
            return f"lift {self.lift!r} reports nothing"
        return f"lift {self.lift!r} is in the mode {self.state.mode!r}" if self.is_out_of_order(now) else ""
