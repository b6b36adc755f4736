"""State machine of one robot's journey: events in, orders out.

All that it knows is in its record, which is stored before the orders that follow from it are obeyed. One that is made
from a stored record repeats the orders that may not have been obeyed: goals of the same ids, requests that their
controllers know, and a change of map that may have happened already.
"""

import math
from collections.abc import Iterable

from msgspec.structs import replace

from ppaas.buildings.doors.states import Pass
from ppaas.buildings.journeys.places import find_landing, landing_of, pose_on, target_of
from ppaas.buildings.journeys.records import (
    AskForDoor,
    AskForLift,
    CancelGoal,
    CancelRide,
    ChangeFloor,
    DoorPassed,
    EnteredCar,
    FindLegs,
    Journey,
    JourneyLeg,
    JourneyOrder,
    JourneyState,
    Keep,
    LeftCar,
    LookForFloor,
    SendGoal,
)
from ppaas.buildings.layout import BuildingLayout
from ppaas.buildings.lifts.states import Alight, Board, Refuse, Wait
from ppaas.buildings.riding.car_frame import is_inside
from ppaas.geometry import Pose2D
from ppaas.tasks.records import Place

TRIES = 4
"""Number of goals of a leg that may fail; then the journey is planned again, and in the end fails."""

CLEAR = 0.6
"""Distance from the door of a lift from which a robot is clear of it [m]: others pass, and it drives on."""

NEAR_LIFT = 3.0
"""Distance from its place before a lift from which a robot asks for the car, on its way there [m]."""

MOST_PLANS = 8
"""Number of plans after which a journey fails: the building does not let it through."""

LIKELY = 0.9
"""Probability from which a floor that lift and scans agree on is taken for granted, although others look alike."""

LOOKS = 4
"""Number of times that a robot turns to look round before it waits for help."""

UNKNOWN = "on which floor it is, is not known"

_NEW_RIDE: dict[str, object] = {"found": "", "lied": "", "looks": 0, "pressure": 0.0, "pressure_at": 0.0}
"""What is not known any more once a ride has ended, or before it begins."""

Orders = list[JourneyOrder]


class JourneyMachine:
    """A journey of one robot. Its methods are events; they return orders, to be obeyed in turn.

    Parameters
    ----------
    journey : Journey
        Its record, stored or new.
    layout : BuildingLayout
    """

    def __init__(self, journey: Journey, layout: BuildingLayout) -> None:
        self.journey = journey
        self._layout = layout
        self._seen: tuple[str, Pose2D] | None = None
        self._drives_in = False
        self._lost: set[str] = set()

    @property
    def is_over(self) -> bool:
        """Whether it has ended."""
        return self.journey.state != "active"

    def seen_at(self, floor: str, pose: Place, now: float) -> Orders:
        """Note where the robot is, on the map of the floor that its clone is on.

        One that nears a lift asks for it; one that is clear of its doors makes way for others, and drives on.
        """
        self._seen = floor, Pose2D(*pose)
        journey = self.journey
        if self.is_over or floor != journey.on:
            return []
        match journey.phase:
            case "driving" if journey.now.kind == "drive" and self._is_near_lift(pose):
                return self._next_leg(now)
            case "boarding" if self._past_door(floor) < -CLEAR:
                self._drives_in = True
                return self._entered()
            case "alighting" if self._past_door(floor) > CLEAR and floor == journey.now.to_floor == journey.found:
                return [] if journey.cancelled else [LeftCar(), *self._next_leg(now)]
            case _:
                return []

    def _is_near_lift(self, pose: Place) -> bool:
        following = self.journey.legs[self.journey.leg + 1 : self.journey.leg + 2]
        return any(leg.kind == "lift" and math.dist(pose[:2], leg.start[:2]) < NEAR_LIFT for leg in following)

    def _past_door(self, floor: str) -> float:
        """Return how far outside of the door of the lift of this leg the robot is [m]; negative inside of the car."""
        landing, pose = landing_of(self._layout, self.journey.now, floor), self._here
        assert pose is not None, "it was seen"
        (x, y), yaw = landing.door.middle, landing.car[2]
        past = float((pose.x - x) * math.cos(yaw) + (pose.y - y) * math.sin(yaw))
        return past if past > 0.0 or is_inside(landing, pose) else 0.0

    # -- begin, plans, end ---------------------------------------------------------------------------------------------

    def resume(self) -> Orders:
        """Begin a new journey, or go on with a stored one, whose last orders may not have been obeyed."""
        journey = self.journey
        if self.is_over:
            return []
        asks = journey.phase in ("waiting", "boarding", "inside", "alighting")
        orders: Orders = [self._request()] if asks else []
        match journey.phase:
            case "planning":
                orders += [Keep(journey), FindLegs(journey.plans)]
            case "waiting":
                pass
            case "inside":
                orders += [EnteredCar(), *([self._change(journey.out)] if journey.out else [])]
            case "looking" if journey.out != journey.on:
                orders += [self._change(journey.out)]
            case _:
                orders += [SendGoal(journey.goal_id, self._target()), *self._look()]
        return orders

    def planned(self, number: int, legs: Iterable[JourneyLeg], now: float) -> Orders:
        """Take the legs of the plan of this number; an earlier one is ignored, as is one without legs."""
        if self.journey.phase != "planning" or number != self.journey.plans or self.is_over:
            return []
        given = tuple(legs)
        if not given:
            return self._end("failed", "there is no way to the goal", now)
        self._set(legs=given, leg=0, failures=0, text="")
        return self._begin_leg()

    def no_plan(self, number: int, text: str, now: float) -> Orders:
        """Note that there is no plan of this number; what was avoided is tried once more before the journey fails."""
        journey = self.journey
        if journey.phase != "planning" or number != journey.plans or self.is_over:
            return []
        if journey.avoid and journey.plans < MOST_PLANS:
            self._set(avoid=(), plans=journey.plans + 1, text=text)
            return [Keep(self.journey), FindLegs(self.journey.plans)]
        return self._end("failed", text, now)

    def cancel(self, now: float) -> Orders:
        """End the journey where the robot is; one in a lift is led out at the next floor first."""
        if self.is_over or self.journey.cancelled:
            return []
        if self.journey.is_aboard:
            self._set(cancelled=True, text="it was cancelled, and the robot leaves the lift")
            return [Keep(self.journey), CancelRide()]
        return [*self._give_back(), *self._end("canceled", "it was cancelled", now)]

    def _end(self, state: JourneyState, text: str, now: float) -> Orders:
        self._set(state=state, text=text, ended=now)
        return [Keep(self.journey)]

    def _call_off(self) -> Orders:
        """Cancel the goal of the robot, whose end does not concern the journey any more."""
        cancelled = CancelGoal(self.journey.goal_id)
        self._set(sent=self.journey.sent + 1)
        return [cancelled]

    def _plan_again(self, text: str, now: float, *avoid: str) -> Orders:
        """Plan from where the robot is, without what has refused it."""
        journey = self.journey
        if journey.plans + 1 >= MOST_PLANS:
            return self._end("failed", text, now)
        known = tuple(dict.fromkeys((*journey.avoid, *avoid)))
        self._set(phase="planning", legs=(), leg=0, failures=0, plans=journey.plans + 1, out="", avoid=known, text=text)
        return [Keep(self.journey), FindLegs(self.journey.plans)]

    def _give_back(self) -> Orders:
        """Cancel what the robot has asked for."""
        match self.journey.phase:
            case "driving" | "crossing" | "looking":
                return [CancelGoal(self.journey.goal_id)]
            case "waiting" if self.journey.now.kind == "lift":
                return [CancelGoal(self.journey.goal_id), CancelRide()]
            case _:
                return []

    # -- legs ----------------------------------------------------------------------------------------------------------

    def _begin_leg(self) -> Orders:
        leg = self.journey.now
        if leg.kind in ("lift", "door"):
            self._set(phase="waiting", out="", **_NEW_RIDE)
            return [Keep(self.journey), self._request()]
        if leg.kind == "way":
            self._set(phase="crossing", out=leg.to_floor)
            return [Keep(self.journey), self._change(leg.to_floor)]
        self._set(phase="driving")
        return self._send()

    def _next_leg(self, now: float) -> Orders:
        journey = self.journey
        if journey.leg + 1 == len(journey.legs):
            return self._end("succeeded", "the goal is reached", now)
        self._set(leg=journey.leg + 1, failures=0, out="", text="")
        return self._begin_leg()

    def _send(self) -> Orders:
        """Send the next goal."""
        self._set(sent=self.journey.sent + 1)
        return [Keep(self.journey), SendGoal(self.journey.goal_id, self._target())]

    def _request(self) -> JourneyOrder:
        leg = self.journey.now
        if leg.kind == "door":
            return AskForDoor(leg.floor, leg.name)
        return AskForLift(leg.name, leg.floor, leg.to_floor)

    def _target(self) -> Place:
        """Return where the robot drives to in its phase."""
        return target_of(self.journey, self._layout, self._here)

    @property
    def _here(self) -> Pose2D | None:
        """Pose of the robot on the map that its clone is on; None if it is not known."""
        return self._seen[1] if self._seen is not None and self._seen[0] == self.journey.on else None

    # -- goals ---------------------------------------------------------------------------------------------------------

    def goal_ended(self, goal_id: str, reached: bool, text: str, now: float) -> Orders:
        """Note the end of a goal; goals that were sent before the last are ignored."""
        journey = self.journey
        moves = journey.phase in ("driving", "boarding", "alighting", "looking", "crossing")
        looks_round = journey.phase == "looking" and not journey.found
        self._drives_in &= goal_id != journey.goal_id
        if self.is_over or goal_id != journey.goal_id or not moves or looks_round:
            return []
        return self._reached(now) if reached else self._failed(text, now)

    def _reached(self, now: float) -> Orders:
        journey = self.journey
        match journey.phase:
            case "boarding":
                return self._entered()
            case "alighting" if journey.cancelled:
                return [LeftCar(), *self._end("canceled", "it was cancelled", now)]
            case "alighting" if not journey.found:
                self._set(phase="looking", failures=0, text="its scans are compared with the maps of the floors")
                return [LeftCar(), Keep(self.journey)]
            case "alighting" | "looking":
                left: Orders = [LeftCar()] if journey.phase == "alighting" else []
                return [*left, *self._ridden(now)]
            case _ if journey.now.kind == "door":
                return [DoorPassed(journey.now.floor, journey.now.name), *self._next_leg(now)]
            case _:
                return self._next_leg(now)

    def _entered(self) -> Orders:
        self._set(phase="inside", failures=0)
        return [Keep(self.journey), EnteredCar()]

    def _ridden(self, now: float) -> Orders:
        """Go on after a ride, from the floor on which the robot has left the car."""
        if self.journey.out != self.journey.now.to_floor:
            return self._plan_again(f"it got out on floor {self.journey.out!r}", now)
        return self._next_leg(now)

    def _failed(self, text: str, now: float) -> Orders:
        """Send the goal again, or plan again; a robot in a car goes on to try, for it cannot stay there."""
        journey = self.journey
        self._set(failures=journey.failures + 1, text=text)
        if journey.phase == "alighting" or self.journey.failures < TRIES:
            return self._send()
        if journey.phase == "boarding":  # it may be in the doorway: it is led out, then it takes another way
            self._set(avoid=tuple(dict.fromkeys((*journey.avoid, journey.now.name))))
            return [Keep(self.journey), CancelRide()]
        if journey.now.kind == "door":
            orders: Orders = [DoorPassed(journey.now.floor, journey.now.name)]
            return [*orders, *self._plan_again(text, now, journey.now.name)]
        return self._plan_again(text, now)

    # -- orders of lifts and doors -------------------------------------------------------------------------------------

    def obey(self, order: Board | Alight | Wait | Refuse | Pass, now: float) -> Orders:
        """Take an order of the controllers of lifts and doors."""
        if self.is_over or self.journey.phase in ("planning", "driving", "looking", "crossing"):
            return []
        waits_for = self.journey.now.kind if self.journey.phase == "waiting" else ""
        orders: Orders = []
        match order:
            case Board(place=place) if waits_for == "lift":
                self._set(phase="boarding", place=place, text="")
                orders = self._send()
            case Pass() if waits_for == "door":
                self._set(phase="driving", text="")
                orders = self._send()
            case Alight(floor=floor):
                orders = self._alight(floor)
            case Wait(reason=reason):
                self._set(text=reason)
            case Refuse(reason=reason):
                orders = self._refused(reason, now)
        return orders

    def _refused(self, reason: str, now: float) -> Orders:
        if self.journey.is_aboard and self.journey.phase != "boarding":
            return []  # it is led out by another order, or people see to it
        orders = self._call_off() if self.journey.phase == "boarding" else []
        return [*orders, *self._plan_again(reason, now, self.journey.now.name)]

    def lift_lost(self, lift: str, text: str, now: float) -> Orders:
        """Note that a lift is out of order: a robot that drives towards it takes another way, if there is one."""
        journey = self.journey
        ahead = [leg.name for leg in journey.legs[journey.leg :] if leg.kind == "lift"]
        if self.is_over or journey.phase != "driving" or lift not in ahead or lift in self._lost:
            return []
        self._lost.add(lift)
        return [*self._call_off(), *self._plan_again(text, now, lift)]

    def _alight(self, floor: str) -> Orders:
        """Leave the car: the clone goes to the map of the floor first, if it is on another one."""
        journey = self.journey
        if journey.phase == "waiting" or journey.now.kind != "lift":
            return []
        if find_landing(self._layout, journey.now, floor) is None:
            return []
        if (journey.phase == "alighting" and journey.out == floor) or journey.lied == floor:
            return []
        drives = self._drives_in or journey.phase in ("boarding", "alighting")
        orders: Orders = [CancelGoal(journey.goal_id)] if drives else []
        if floor != journey.on:
            self._set(phase="inside", out=floor, found="", lied="")
            return [*orders, Keep(self.journey), self._change(floor)]
        found = floor if journey.phase == "boarding" or self._drives_in else ""  # then the car has not moved
        self._set(phase="alighting", out=floor, failures=0, found=found, lied="")
        return [*orders, *self._send(), *self._look()]

    def doors_closed(self, stop: str) -> Orders:
        """Note that the doors of the car are closed, and the floor where it stops next; empty if that is not known.

        Once the robot stands, its clone goes to the map of that floor, as those of all who share the car: there they
        see each other, and pass the door one after the other. A car that has let a robot out on a wrong floor, and
        closes its doors before it is out, may go anywhere.
        """
        journey = self.journey
        if journey.lied and journey.is_aboard and not self.is_over:
            self._set(found="", lied="")
            return [Keep(self.journey), *self._look()]
        if self._drives_in or self.is_over or journey.phase != "inside" or journey.out:
            return []
        floor = stop if stop and find_landing(self._layout, journey.now, stop) is not None else journey.now.to_floor
        return [] if journey.on == floor else [self._change(floor)]

    # -- maps ----------------------------------------------------------------------------------------------------------

    def _change(self, floor: str) -> ChangeFloor:
        """Return the order to move the clone to the map of a floor, at the pose that the robot has there."""
        return ChangeFloor(floor, pose_on(floor, self.journey, self._layout, self._here))

    def on_floor(self, floor: str) -> Orders:
        """Note that the clone is on the map of a floor, and localized there."""
        journey = self.journey
        if self.is_over or floor == journey.on:
            return []
        self._set(on=floor)
        if journey.out != floor:
            return [Keep(self.journey)]
        if journey.phase == "crossing":
            return self._send()
        if journey.phase == "inside":
            self._set(phase="alighting", failures=0)
            return [*self._send(), *self._look()]
        if journey.phase == "looking":
            return self._send()
        return [Keep(self.journey)]

    # -- on which floor it is ------------------------------------------------------------------------------------------

    def measured(self, pascal: float, now: float) -> Orders:
        """Note the pressure of the air at which the robot has come into the car [Pa]."""
        if self.is_over or self.journey.phase != "inside":
            return []
        self._set(pressure=pascal, pressure_at=now)
        return [Keep(self.journey)]

    def looked(self, floor: str, known: bool, probability: float, pose: Place, now: float) -> Orders:
        """Take the likeliest floor by scans, lift and barometer, whether it is known, and the pose on its map."""
        journey = self.journey
        if not journey.looks_for_floor:
            return []
        if known and floor != journey.on:
            return self._is_elsewhere(floor, pose)
        if floor == journey.on and (known or probability >= LIKELY):
            return self._is_here(now)
        return self._look_round()

    def cannot_look(self, now: float) -> Orders:
        """Note that nobody can compare scans with maps, so that the lift is believed."""
        return self._is_here(now) if self.journey.looks_for_floor else []

    def _look(self) -> Orders:
        return [LookForFloor()] if self.journey.looks_for_floor else []

    def _is_here(self, now: float) -> Orders:
        self._set(found=self.journey.on)
        return [Keep(self.journey)] if self.journey.phase == "alighting" else self._ridden(now)

    def _is_elsewhere(self, floor: str, pose: Place) -> Orders:
        """Move the clone to the map of the floor that the robot is really on; there it leaves the car if need be."""
        journey = self.journey
        phase = "inside" if journey.phase == "alighting" else "looking"
        text = f"it is on floor {floor!r}, not on {journey.on!r}"
        self._set(phase=phase, out=floor, found=floor, lied=journey.on, failures=0, text=text)
        return [CancelGoal(journey.goal_id), Keep(self.journey), ChangeFloor(floor, pose)]

    def _look_round(self) -> Orders:
        """Turn the robot, if it is out of the car, and look again; after some turns it waits for help."""
        journey = self.journey
        if journey.phase == "alighting":
            return self._look()
        self._set(looks=min(journey.looks + 1, LOOKS + 1))
        if self.journey.looks > LOOKS:
            self._set(text=f"{UNKNOWN}: it waits, for its scans fit no floor, or several")
            return [Keep(self.journey), *self._look()]
        self._set(text=f"{UNKNOWN}: it looks round")
        return [*self._send(), *self._look()]

    # -- internals -----------------------------------------------------------------------------------------------------

    def _set(self, **changes: object) -> None:
        self.journey = replace(self.journey, **changes)
