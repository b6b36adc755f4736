"""State machine of a goal to dock: what the robot senses in, what it does out.

One approach consists of these phases, of which the last three are repeated until the battery is charged::

    STAGING → PERCEIVING → APPROACHING → WAITING ⇄ PRESSING → docked
                    ↑________________________________|  BACKING

Contact is not charge: only readings of the battery end WAITING with success. Where the robot takes up a load, LIFTING
follows, which only the report of its lift ends with success. A robot that fails for good backs off too, so that it does
not stand at a dock that does not charge it.
"""

import math
from collections.abc import Sequence
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.base import Velocity
from ppaas.docking.approach import BodyOutline, along_axis, apart_from_dock, is_in_way
from ppaas.docking.charge import ChargeVerdict, ChargeWatch, uncharged
from ppaas.docking.detection.base import NO_POINTS, DockView
from ppaas.docking.dock import MappedDock
from ppaas.docking.failures import (
    DockingFailure,
    DockLost,
    DockNotReached,
    DockNotSeen,
    LiftFailed,
    NotStaged,
    lift_problem,
)
from ppaas.docking.orders import STAND, Docked, DriveTo, Order, Sight
from ppaas.docking.parameters import DockingParameters
from ppaas.docking.pose_filter import DockPoseFilter
from ppaas.docking.targets import DockTarget
from ppaas.geometry import Pose2D, wrap_angle

LOST = 1.5
"""Time without sight of the dock after which it is lost [s]."""

STALLED, STEP = 1.5, 0.005
"""Time in which a driving robot comes nearer by a step [s, m]; else it is pressed against something."""

TOUCH = 0.08
"""Distance from the docked pose at which a robot that does not come nearer touches the dock [m]."""

LONGER = 4.0
"""Factor on the time to wait for charge while there are too few readings of the battery."""

ALIGNED = 0.3
"""Largest difference to the heading of the staging pose at which a robot need not drive there first [rad]."""

NEAR = 0.3
"""Distance by which a robot that does not drive to the staging pose may be further away than the dock itself [m]."""

AWAY = 0.8
"""Distance by which a robot may be further away than the staging pose [m]."""

BACKING_TIME = 20.0
"""Time in which a robot backs off [s]."""


class DockingPhase(Enum):
    """What the robot does."""

    STAGING = "driving to the staging pose"
    PERCEIVING = "looking for the dock"
    APPROACHING = "driving to the dock"
    WAITING = "waiting for charge"
    PRESSING = "pressing on"
    LIFTING = "lifting the load"
    BACKING = "backing off"


class Docking:
    """Docks a robot, at the first of some docks where that succeeds.

    Parameters
    ----------
    targets : sequence of DockTarget
        The dock, and those to try if it fails.
    parameters : DockingParameters
    body : BodyOutline
    braking : float
        Deceleration of the robot [m/s²].
    now : float
        Time of the start [s].
    navigate : bool
        Whether the robot drives to the staging pose; else it must be there.
    staging_time : float
        Time for that [s].

    Attributes
    ----------
    phase : DockingPhase
    retries : int
        Number of further approaches so far.
    text : str
        What the robot does, in words.
    lift : bool or None
        Whether the lift is to be up; None as long as it is not used.
    """

    def __init__(
        self, targets: Sequence[DockTarget], parameters: DockingParameters, body: BodyOutline, *, braking: float,
        now: float, navigate: bool = True, staging_time: float = math.inf,
    ) -> None:  # fmt: skip
        self._rest = list(targets)
        self._parameters, self._body, self._braking = parameters, body, braking
        self._navigate, self._staging_time = navigate, staging_time
        self._steps = {
            DockingPhase.STAGING: self._stage, DockingPhase.PERCEIVING: self._perceive,
            DockingPhase.APPROACHING: self._approach, DockingPhase.WAITING: self._wait,
            DockingPhase.PRESSING: self._press, DockingPhase.LIFTING: self._lift, DockingPhase.BACKING: self._back_off,
        }  # fmt: skip
        self.lift: bool | None = None
        self.phase, self.retries, self.text = DockingPhase.STAGING, 0, ""
        self._last = now
        self._points: NDArray[np.float64] = NO_POINTS
        self._points_in = Pose2D(0.0, 0.0)
        self._since = self._free_at = self._near_at = now
        self._nearest = -math.inf
        self._begin(now)

    def _begin(self, now: float) -> None:
        """Begin with the next dock."""
        self._target = self._rest.pop(0)
        self.charge = ChargeWatch(self._target.type.charging_threshold)
        self._filter = DockPoseFilter()
        self._attempt, self._sent, self._pressed, self._from = 0, False, False, Pose2D(0.0, 0.0)
        self._failure: DockingFailure | None = None
        self._enter(DockingPhase.STAGING, now)

    @property
    def dock(self) -> MappedDock:
        """The dock to which the robot drives."""
        return self._target.dock

    @property
    def drives_itself(self) -> bool:
        """Whether the velocities are this machine's, and not Move Base's."""
        return self.phase is not DockingPhase.STAGING

    def staged(self, failure: str, now: float) -> DockingFailure | None:
        """Take the end of the way to the staging pose; return a failure for good.

        Parameters
        ----------
        failure : str
            Why the pose was not reached; empty if it was.
        now : float
            Time [s].
        """
        if self.phase is not DockingPhase.STAGING:
            return None
        if not failure:
            self._enter(DockingPhase.PERCEIVING, now)
            return None
        order = self._next(NotStaged(f"the staging pose of {self.dock.in_words} was not reached: {failure}"), now)
        return order if isinstance(order, DockingFailure) else None

    def step(self, sight: Sight) -> Order:
        """Return what the robot does now."""
        waited, self._last = sight.now - self._last, sight.now
        self.text = self._doing
        if sight.held and self.drives_itself:
            self._pause(waited)
            self.text = f"waiting: {sight.held}"
            return STAND
        if self.drives_itself and self._is_away(sight):
            self._begin_again(sight.now)
        order = self._steps[self.phase](sight)
        if isinstance(order, Velocity) and self._is_blocked(sight, order):
            self._pause(waited)
            if sight.now - self._free_at > self._parameters.patience:
                blocked = DockNotReached(f"something is in the way to {self.dock.in_words}")
                return self._next(self._failure or blocked, sight.now)
            self.text = "waiting: something is in the way"
            return STAND
        self._free_at = sight.now
        return order

    def _is_away(self, sight: Sight) -> bool:
        """Return whether somebody has moved the robot far from the dock: from there it does not drive straight on."""
        place = self._place(sight)
        return place is not None and math.hypot(place.x, place.y) > self._target.type.staging_distance + AWAY

    def _begin_again(self, now: float) -> None:
        """Drive to the staging pose again."""
        self._filter, self._failure, self._sent = DockPoseFilter(), None, False
        self._enter(DockingPhase.STAGING, now)

    def _pause(self, seconds: float) -> None:
        """Let time pass in which the robot cannot drive."""
        self._since += seconds
        self._near_at += seconds

    def _enter(self, phase: DockingPhase, now: float) -> None:
        self.phase, self._since, self._free_at = phase, now, now
        self._nearest, self._near_at = -math.inf, now
        self.text = self._doing = f"{phase.value} ({self.dock.in_words})"

    # -- phases --------------------------------------------------------------------------------------------------------

    def _stage(self, sight: Sight) -> Order:
        target, now = self._target, sight.now
        in_map = None if sight.map_in_odom is None else sight.map_in_odom.inverse() @ sight.odometry
        if in_map is not None and not self._sent:
            tolerance = self._parameters.dock_prestaging_tolerance
            apart = in_map.distance_to(target.staging)
            aligned = abs(wrap_angle(in_map.theta - target.staging.theta)) <= ALIGNED
            if (apart <= tolerance and aligned) or not self._navigate:
                if not self._navigate and apart > target.type.staging_distance + NEAR:
                    text = f"the robot is {apart:.2f} m from the staging pose of {target.dock.in_words}: drive it there"
                    return self._next(NotStaged(text), now)
                self._enter(DockingPhase.PERCEIVING, now)
                return STAND
            self._sent = True
            return DriveTo(target.staging)
        if now - self._since > self._staging_time:
            why = "" if self._sent else ": the robot is not localized"
            text = f"{target.dock.in_words} was not reached in {self._staging_time:g} s{why}"
            return self._next(NotStaged(text), now)
        return STAND

    def _perceive(self, sight: Sight) -> Order:
        self._look(sight)
        if self._filter.pose is not None:
            self._enter(DockingPhase.APPROACHING, sight.now)
        elif sight.now - self._since > self._parameters.initial_perception_timeout:
            return self._fail(DockNotSeen(self._not_seen(sight)), sight)
        return STAND

    def _approach(self, sight: Sight) -> Order:
        self._look(sight)
        place, kind, now = self._place(sight), self._target.type, sight.now
        if place is None or (now - self._filter.seen_at > LOST and place.x < -kind.blind_distance):
            return self._fail(DockLost(f"{self.dock.in_words} is not seen any more"), sight)
        if place.x >= -kind.docking_threshold or self._touches(place, now):
            self._enter(DockingPhase.WAITING, now)
            self._pressed = False
            return self._wait(sight)
        if abs(place.y) > kind.lateral_tolerance and place.x > -2.0 * kind.docking_threshold - kind.lateral_tolerance:
            text = f"the robot came to {self.dock.in_words} {abs(place.y):.2f} m beside its axis"
            return self._fail(DockNotReached(text), sight)
        if now - self._since > self._parameters.dock_approach_timeout or now - self._near_at > 4.0 * STALLED:
            return self._fail(DockNotReached(f"the robot does not come nearer to {self.dock.in_words}"), sight)
        velocity = along_axis(place, self._parameters.controller, to=0.05, ahead=self._target.stance.ahead)
        if place.x > self._nearest + STEP or velocity.linear == 0.0:
            self._nearest, self._near_at = max(place.x, self._nearest), now
        return velocity

    def _touches(self, place: Pose2D, now: float) -> bool:
        """Return whether the dock stops the robot, or charges it already."""
        if place.x < -TOUCH:
            return False
        charged = self.dock.charges and self.charge.verdict(self._since) is ChargeVerdict.CHARGING
        return charged or now - self._near_at > STALLED

    def _wait(self, sight: Sight) -> Order:
        if self._target.type.load:
            self.lift = True
            self._enter(DockingPhase.LIFTING, sight.now)
            return STAND
        if not self.dock.charges:
            return Docked(self.dock, sight.odometry)
        verdict, limit = self.charge.verdict(self._since), self._parameters.wait_charge_timeout
        if verdict is ChargeVerdict.CHARGING:
            return Docked(self.dock, sight.odometry)
        if sight.now - self._since <= (LONGER * limit if verdict is ChargeVerdict.UNDECIDED else limit):
            return STAND
        if verdict is ChargeVerdict.NOT_CHARGING and not self._pressed and self._target.type.overshoot > 0.0:
            self._pressed, self._from = True, sight.odometry
            self._enter(DockingPhase.PRESSING, sight.now)
            return STAND
        return self._fail(uncharged(self.dock.in_words, verdict, self.charge.current(self._since)), sight)

    def _lift(self, sight: Sight) -> Order:
        if sight.lifted:
            return Docked(self.dock, sight.odometry)
        if sight.now - self._since <= self._parameters.lift_timeout:
            return STAND
        self.lift = False
        return self._fail(LiftFailed(f"at {self.dock.in_words} {lift_problem(sight.lifted, up=True)}"), sight)

    def _press(self, sight: Sight) -> Order:
        speed, kind = self._parameters.controller.v_linear_min, self._target.type
        driven = sight.odometry.distance_to(self._from)
        charged = self.charge.verdict(self._since) is ChargeVerdict.CHARGING
        if charged or driven >= kind.overshoot or sight.now - self._since > 2.0 * kind.overshoot / speed + 1.0:
            self._enter(DockingPhase.WAITING, sight.now)
            return STAND
        return Velocity(self._target.stance.ahead * speed, 0.0)

    def _back_off(self, sight: Sight) -> Order:
        place, now = self._place(sight), sight.now
        if self.lift is False and sight.lifted and now - self._since <= self._parameters.lift_timeout:
            return STAND  # it came up late, and has to go down first
        goal = -self._target.type.staging_distance
        if place is None or place.x <= goal + 0.02 or now - self._since > BACKING_TIME:
            assert self._failure is not None, "a robot backs off from a failure"
            if self._gives_up(self._failure):
                return self._next(self._failure, now)
            self._attempt += 1
            self.retries += 1
            self._filter, self._failure = DockPoseFilter(), None
            self._enter(DockingPhase.PERCEIVING, now)
            return STAND
        return along_axis(place, self._parameters.controller, to=goal, ahead=self._target.stance.ahead)

    # -- the dock ------------------------------------------------------------------------------------------------------

    def _look(self, sight: Sight) -> None:
        """Look for the dock if something is new."""
        if sight.view is None:
            return
        mapped = self._mapped(sight)
        known = self._filter.guess or mapped
        if known is None:
            return
        to_robot = sight.odometry.inverse()
        view = DockView(
            sight.view.points, sight.view.intensities, sight.view.detected,
            None if mapped is None else to_robot @ mapped,
        )  # fmt: skip
        face = self._target.detector.detect(view, to_robot @ known)
        if face is not None:
            self._filter.take(sight.odometry @ face, sight.now)

    def _mapped(self, sight: Sight) -> Pose2D | None:
        """Return the face of the dock by the map, in the odometry frame."""
        face = self._target.stance.face_of(self.dock.pose)
        return None if sight.map_in_odom is None else sight.map_in_odom @ face

    def _axis(self, sight: Sight) -> Pose2D | None:
        """Return the frame whose x is the way of the robot into the dock, beside its axis for a further approach."""
        face = self._filter.guess or self._mapped(sight)
        if face is None:
            return None
        docked = self._target.stance.docked_at(face)
        return Pose2D(docked.x, docked.y, face.theta) @ Pose2D(0.0, self._offset)

    @property
    def _offset(self) -> float:
        """Distance of this approach from the axis [m], to the left."""
        far = (self._attempt + 1) // 2 * self._parameters.retry_offset
        return far if self._attempt % 2 else -far

    def _place(self, sight: Sight) -> Pose2D | None:
        """Return the place of the robot on its way into the dock: heading 0 is that of a docked robot."""
        axis = self._axis(sight)
        if axis is None:
            return None
        place = axis.inverse() @ sight.odometry
        turn = math.pi if self._target.stance.backward else 0.0
        return Pose2D(place.x, place.y, wrap_angle(place.theta + turn))

    def _not_seen(self, sight: Sight) -> str:
        if sight.map_in_odom is None:
            return f"{self.dock.in_words} was not looked for: the robot is not localized"
        return f"{self.dock.in_words} is not seen: it was looked for by {self._target.detector.purpose}"

    def _is_blocked(self, sight: Sight, velocity: Velocity) -> bool:
        """Return whether something but the dock is in the way, as far as the last scan shows."""
        if sight.view is not None:
            self._points, self._points_in = sight.view.points, sight.odometry
        if not velocity.linear:
            return False
        moved = sight.odometry.inverse() @ self._points_in
        c, s = math.cos(moved.theta), math.sin(moved.theta)
        points = self._points @ ((c, s), (-s, c)) + (moved.x, moved.y)
        axis = self._axis(sight)
        if axis is not None:
            front = axis @ Pose2D(self._body.back if self._target.stance.backward else self._body.front, 0.0)
            points = apart_from_dock(points, sight.odometry.inverse() @ front, self._target.detector.protrusion)
        return is_in_way(points, self._body, velocity, self._braking)

    # -- failures ------------------------------------------------------------------------------------------------------

    def _fail(self, failure: DockingFailure, sight: Sight) -> Order:
        """Back off after a failure."""
        self._failure = failure
        self._enter(DockingPhase.BACKING, sight.now)
        self.text = self._doing = f"backing off: {failure}"
        return self._back_off(sight)

    def _gives_up(self, failure: DockingFailure) -> bool:
        return not failure.curable or self._attempt >= self._parameters.max_retries

    def _next(self, failure: DockingFailure, now: float) -> Order:
        """Drive to the next dock, or end with the failure of the last."""
        if not self._rest:
            return failure
        self._begin(now)
        return STAND
