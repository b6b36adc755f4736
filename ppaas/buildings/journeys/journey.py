"""State machine of one robot's journey: events in, orders out.

All that it knows is in its record, which is stored before the orders that follow from it are obeyed. One that is made
from a stored record repeats the orders that may not have been obeyed: goals of the same ids, requests that their
controllers know, and a change of map that may have happened already.
"""

import math
from collections.abc import Iterable

from msgspec.structs import replace

from ppaas.buildings.doors.states import Pass
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
    SendGoal,
)
from ppaas.buildings.layout import BuildingLayout, Landing
from ppaas.buildings.lifts.states import Alight, Board, Refuse, Wait
from ppaas.buildings.riding.car_frame import carried, is_inside, places_in_car
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.tasks.records import Place

TRIES = 4
"""Number of goals of a leg that may fail; then the journey is planned again, and in the end fails."""

CLEAR = 0.6
"""Distance from the door of a lift from which a robot is clear of it [m]: others pass, and it drives on."""

NEAR_LIFT = 3.0
"""Distance from its place before a lift from which a robot asks for the car, on its way there [m]."""

MOST_PLANS = 8
"""Number of plans after which a journey fails: the building does not let it through."""

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
            case "boarding" if self._past_door(floor) < -CLEAR and is_inside(self._landing(floor), self._seen[1]):
                self._drives_in = True
                return self._entered()
            case "alighting" if self._past_door(floor) > CLEAR and floor == journey.now.to_floor == journey.out:
                return [] if journey.cancelled else [LeftCar(), *self._next_leg(now)]
            case _:
                return []

    def _is_near_lift(self, pose: Place) -> bool:
        following = self.journey.legs[self.journey.leg + 1 : self.journey.leg + 2]
        return any(leg.kind == "lift" and math.dist(pose[:2], leg.start[:2]) < NEAR_LIFT for leg in following)

    def _past_door(self, floor: str) -> float:
        """Return how far outside of the door of the lift of this leg the robot is [m]; negative inside."""
        landing = self._landing(floor)
        assert self._seen is not None, "it was seen"
        (x, y), yaw = landing.door.middle, landing.car[2]
        return (self._seen[1].x - x) * math.cos(yaw) + (self._seen[1].y - y) * math.sin(yaw)

    # -- begin, plans, end ---------------------------------------------------------------------------------------------

    def resume(self) -> Orders:
        """Begin a new journey, or go on with a stored one, whose last orders may not have been obeyed."""
        journey = self.journey
        if self.is_over:
            return []
        match journey.phase:
            case "planning":
                return [Keep(journey), FindLegs(journey.plans)]
            case "waiting":
                return [self._request()]
            case "inside":
                orders: Orders = [self._request(), EnteredCar()]
                return [*orders, *([self._change(journey.out)] if journey.out else [])]
            case "boarding" | "alighting":
                return [self._request(), SendGoal(journey.goal_id, self._target())]
            case _:
                return [SendGoal(journey.goal_id, self._target())]

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
            case "driving" | "crossing":
                return [CancelGoal(self.journey.goal_id)]
            case "waiting" if self.journey.now.kind == "lift":
                return [CancelGoal(self.journey.goal_id), CancelRide()]
            case _:
                return []

    # -- legs ----------------------------------------------------------------------------------------------------------

    def _begin_leg(self) -> Orders:
        leg = self.journey.now
        if leg.kind in ("lift", "door"):
            self._set(phase="waiting", out="")
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
        journey, leg = self.journey, self.journey.now
        if journey.phase == "boarding":
            landings, landing = self._layout.landings[leg.name], self._landing(leg.floor)
            places = places_in_car(self._layout.building, landings, landing)
            x, y, yaw = places[min(journey.place, len(places) - 1)]
            return x, y, yaw
        if journey.phase == "alighting":
            if journey.out == leg.to_floor:
                return leg.goal
            x, y, yaw = self._landing(journey.out).wait
            return x, y, wrap_angle(yaw + math.pi)
        return leg.goal

    # -- goals ---------------------------------------------------------------------------------------------------------

    def goal_ended(self, goal_id: str, reached: bool, text: str, now: float) -> Orders:
        """Note the end of a goal; goals that were sent before the last are ignored."""
        journey = self.journey
        moves = journey.phase in ("driving", "boarding", "alighting", "crossing")
        self._drives_in &= goal_id != journey.goal_id
        if self.is_over or goal_id != journey.goal_id or not moves:
            return []
        return self._reached(now) if reached else self._failed(text, now)

    def _reached(self, now: float) -> Orders:
        journey = self.journey
        match journey.phase:
            case "boarding":
                return self._entered()
            case "alighting" if journey.cancelled:
                return [LeftCar(), *self._end("canceled", "it was cancelled", now)]
            case "alighting" if journey.out != journey.now.to_floor:
                return [LeftCar(), *self._plan_again(f"it got out on floor {journey.out!r}", now)]
            case "alighting":
                return [LeftCar(), *self._next_leg(now)]
            case _ if journey.now.kind == "door":
                return [DoorPassed(journey.now.floor, journey.now.name), *self._next_leg(now)]
            case _:
                return self._next_leg(now)

    def _entered(self) -> Orders:
        self._set(phase="inside", failures=0)
        return [Keep(self.journey), EnteredCar()]

    def _failed(self, text: str, now: float) -> Orders:
        """Send the goal again, or plan again; a robot in a car goes on to try, for it cannot stay there."""
        journey = self.journey
        self._set(failures=journey.failures + 1, text=text)
        if journey.phase == "alighting" or self.journey.failures < TRIES:
            return self._send()
        if (
            journey.phase == "boarding"
        ):  # it may be in the doorway: the controller leads it out, then it takes another way
            self._set(avoid=tuple(dict.fromkeys((*journey.avoid, journey.now.name))))
            return [Keep(self.journey), CancelRide()]
        if journey.now.kind == "door":
            orders: Orders = [DoorPassed(journey.now.floor, journey.now.name)]
            return [*orders, *self._plan_again(text, now, journey.now.name)]
        return self._plan_again(text, now)

    # -- orders of lifts and doors -------------------------------------------------------------------------------------

    def obey(self, order: Board | Alight | Wait | Refuse | Pass, now: float) -> Orders:
        """Take an order of the controllers of lifts and doors."""
        if self.is_over or self.journey.phase in ("planning", "driving", "crossing"):
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
        if journey.phase == "waiting" or journey.now.kind != "lift" or self._find(floor) is None:
            return []
        if journey.phase == "alighting" and journey.out == floor:
            return []
        drives = self._drives_in or journey.phase in ("boarding", "alighting")
        orders: Orders = [CancelGoal(journey.goal_id)] if drives else []
        if floor != journey.on:
            self._set(phase="inside", out=floor)
            return [*orders, Keep(self.journey), self._change(floor)]
        self._set(phase="alighting", out=floor, failures=0)
        return [*orders, *self._send()]

    def doors_closed(self, stop: str) -> Orders:
        """Note that the doors of the car are closed, and the floor where it stops next; empty if that is not known.

        Once the robot stands, its clone goes to the map of that floor, as those of all who share the car: there they
        see each other, and pass the door one after the other.
        """
        journey = self.journey
        if self._drives_in or self.is_over or journey.phase != "inside" or journey.out:
            return []
        floor = stop if stop and self._find(stop) is not None else journey.now.to_floor
        return [] if journey.on == floor else [self._change(floor)]

    # -- maps ----------------------------------------------------------------------------------------------------------

    def _change(self, floor: str) -> ChangeFloor:
        """Return the order to move the clone to the map of a floor, at the pose that the robot has there."""
        journey, leg = self.journey, self.journey.now
        if leg.kind == "way":
            x, y, yaw = leg.goal
            return ChangeFloor(floor, (x - leg.length * math.cos(yaw), y - leg.length * math.sin(yaw), yaw))
        origin = self._landing(journey.on)
        here = Pose2D(*origin.car)
        if self._seen is not None and self._seen[0] == journey.on and is_inside(origin, self._seen[1]):
            here = self._seen[1]
        pose = carried(self._layout.building, origin, self._landing(floor), here)
        return ChangeFloor(floor, (pose.x, pose.y, pose.theta))

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
            return self._send()
        return [Keep(self.journey)]

    def is_really_on(self, floor: str, pose: Place, now: float) -> Orders:
        """Note that scans have shown the robot on another floor than it was taken to be: it got out wrong.

        The clone goes to the map of that floor, and the journey is planned again from there.
        """
        journey = self.journey
        if self.is_over or floor == journey.on:
            return []
        was_riding = journey.phase in ("inside", "alighting")
        orders: Orders = [] if journey.phase == "planning" else [CancelGoal(journey.goal_id)]
        orders += [LeftCar()] if was_riding else []
        text = f"it is on floor {floor!r}, not on {journey.on!r}"
        self._set(on=floor)
        return [*orders, ChangeFloor(floor, pose), *self._plan_again(text, now)]

    # -- internals -----------------------------------------------------------------------------------------------------

    def _find(self, floor: str) -> Landing | None:
        """Return the landing of the lift of this leg on a floor; the door that it takes there, if there are two."""
        leg = self.journey.now
        found = [each for each in self._layout.landings.get(leg.name, ()) if each.floor == floor]
        ends = [place for place, on in ((leg.start, leg.floor), (leg.goal, leg.to_floor)) if on == floor]
        return min(found, key=lambda each: _apart(each.wait, ends), default=None)

    def _landing(self, floor: str) -> Landing:
        found = self._find(floor)
        assert found is not None, "legs are planned on this layout"
        return found

    def _set(self, **changes: object) -> None:
        self.journey = replace(self.journey, **changes)


def _apart(wait: Place, ends: list[Place]) -> float:
    return min((math.hypot(wait[0] - x, wait[1] - y) for x, y, _ in ends), default=0.0)
