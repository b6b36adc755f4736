"""Simulated lift: a car that accelerates, doors that take time, people who use it, and its faults."""

import math
import random
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ppaas.buildings.lifts.states import EndSession, LiftMode, LiftRequest, LiftState

HOLD = 10.0
"""Time without a request after which a lift ends a session by itself [s]."""

STEP = 0.1
"""Step of the simulation [s]."""

DWELL = 4.0
"""Time for which doors stay open for people [s]."""


@dataclass(frozen=True, slots=True)
class LiftModel:
    """Properties of a simulated lift.

    Parameters
    ----------
    speed, acceleration : float
        Largest speed and acceleration of the car [m/s, m/s²].
    doors : float
        Time in which the doors open or close [s].
    people : float
        Mean number of trips of people in an hour, while robots do not have the lift.
    wrong_floor : float
        Share of requests for another floor that the lift takes for a third one, or for its own.
    seed : int
        Seed of people and faults.
    breaks : float
        Time after its begin at which it goes out of order [s]; infinite if it does not.
    """

    speed: float = 1.0
    acceleration: float = 0.8
    doors: float = 3.0
    people: float = 0.0
    wrong_floor: float = 0.0
    seed: int = 0
    breaks: float = math.inf


class SimulatedLift:
    """Lift.

    Parameters
    ----------
    lift : str
    levels : mapping of str to float
        Height of each floor [m], from the lowest; at least one.
    now : float
        Time [s], as everywhere here.
    model : LiftModel

    Attributes
    ----------
    blocked : bool
        Whether its light curtain sees something between the doors, which open then.
    """

    def __init__(self, lift: str, levels: Mapping[str, float], now: float, model: LiftModel | None = None) -> None:
        self.lift, self._levels, self._now = lift, dict(levels), now
        self._model = LiftModel() if model is None else model
        self._random = random.Random(self._model.seed)
        self._height = min(self._levels.values())
        self._velocity = 0.0
        self._opened = 0.0
        self.blocked = False
        self._mode: LiftMode = "agv"
        self._session, self._heard = "", now
        self._asked = self._target = next(iter(self._levels))
        self._people: deque[str] = deque()
        self._dwells_until = now
        self._next_trip = self._draw_trip(now)
        self._breaks_at = now + self._model.breaks

    # -- what is done to it --------------------------------------------------------------------------------------------

    def request(self, request: LiftRequest, now: float) -> None:
        """Obey a request, if the lift is free or has its session."""
        self.advance(now)
        is_free = self._mode == "agv" and not self._people and self._session in ("", request.session)
        if not is_free or request.floor not in self._levels:
            return
        if self._session != request.session or request.floor != self._asked:
            self._asked = self._target = request.floor
            if request.floor != self._floor() and self._random.random() < self._model.wrong_floor:
                self._target = self._random.choice([name for name in self._levels if name != request.floor])
        elif self._target != self._asked and self._is_standing_at(self._target) and self._opened >= 1.0:
            self._target = self._asked
        self._session, self._heard = request.session, now

    def end(self, end: EndSession, now: float) -> None:
        """End a session."""
        self.advance(now)
        if self._session == end.session:
            self._session = ""

    def set_mode(self, mode: LiftMode, now: float) -> None:
        """Change the mode, as a key switch or an alarm does; in case of fire the car drives to the lowest floor."""
        self.advance(now)
        self._mode = mode
        if mode != "agv":
            self._session = ""
        self._people.clear()
        if mode == "fire":
            self._target = min(self._levels, key=self._levels.__getitem__)

    # -- what it does --------------------------------------------------------------------------------------------------

    def advance(self, now: float) -> None:
        """Simulate until a time."""
        while now - self._now >= STEP:
            self._now += STEP
            self._step()

    def state(self, now: float) -> LiftState:
        """Return what the lift reports."""
        self.advance(now)
        motion: Literal["up", "down", "stopped"] = "stopped"
        if self._velocity:
            motion = "up" if self._velocity > 0.0 else "down"
        door: Literal["open", "closed", "moving"] = "moving"
        if self._opened in (0.0, 1.0):
            door = "open" if self._opened else "closed"
        mode = "human" if self._mode == "agv" and self._people else self._mode
        floors = tuple(self._levels)
        return LiftState(
            lift=self.lift,
            floor=self._floor(),
            door=door,
            motion=motion,
            mode=mode,
            session=self._session,
            floors=floors,
        )

    # -- internals -----------------------------------------------------------------------------------------------------

    def _step(self) -> None:
        now = self._now
        if now >= self._breaks_at:
            self._breaks_at = math.inf
            self._mode, self._session = "offline", ""
        if self._session and now - self._heard > HOLD:
            self._session = ""
        self._let_people_use_it(now)
        moving_allowed = self._mode in ("agv", "fire")
        if self._is_standing_at(self._target):
            self._move_doors(open_=self._is_held_open(now))
        elif self._opened > 0.0:
            self._move_doors(open_=False)
        elif moving_allowed:
            self._drive()

    def _is_held_open(self, now: float) -> bool:
        return self._mode == "fire" or bool(self._session) or now < self._dwells_until

    def _move_doors(self, *, open_: bool) -> None:
        change = STEP / max(self._model.doors, STEP)
        self._opened = min(self._opened + change, 1.0) if open_ or self.blocked else max(self._opened - change, 0.0)

    def _drive(self) -> None:
        """Accelerate towards the target, as fast as the car can still stop there."""
        model, gap = self._model, self._levels[self._target] - self._height
        limit = min(model.speed, (2.0 * model.acceleration * abs(gap)) ** 0.5)
        wanted = limit if gap > 0.0 else -limit
        change = model.acceleration * STEP
        self._velocity += min(max(wanted - self._velocity, -change), change)
        step = self._velocity * STEP
        if abs(step) >= abs(gap) or abs(gap) < 0.005:
            self._height, self._velocity = self._levels[self._target], 0.0
        else:
            self._height += step

    def _let_people_use_it(self, now: float) -> None:
        """Serve people while no session holds the lift."""
        if self._mode != "agv" or self._session:
            self._next_trip = max(self._next_trip, now)
            return
        if not self._people and now >= self._next_trip:
            names = list(self._levels)
            origin = self._random.choice(names)
            self._people.extend([origin, self._random.choice([name for name in names if name != origin] or names)])
            self._target = self._people[0]
            self._next_trip = self._draw_trip(now)
            self._dwells_until = now
        if self._people and self._is_standing_at(self._people[0]):
            if self._opened >= 1.0 and self._dwells_until <= now:
                self._people.popleft()
                self._target = self._people[0] if self._people else self._target
            elif self._opened < 1.0:
                self._dwells_until = now + DWELL

    def _draw_trip(self, now: float) -> float:
        return now + self._random.expovariate(self._model.people / 3600.0) if self._model.people > 0.0 else float("inf")

    def _is_standing_at(self, floor: str) -> bool:
        return not self._velocity and self._height == self._levels[floor]

    def _floor(self) -> str:
        """Return the nearest floor."""
        return min(self._levels, key=lambda name: abs(self._levels[name] - self._height))
