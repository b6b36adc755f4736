"""State of a coordinator: as a message, and as a checkpoint of identities, filters, orders and counts."""

import math
from typing import Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.decoding import from_msgpack
from ppaas.errors import InvalidInput
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import LOST, FollowOrder, GroupRobot, PeopleState, TrackedPerson
from ppaas.people.coordinator.follow_controller import FollowAssignment, FollowController
from ppaas.people.coordinator.group import Earlier, Robots
from ppaas.people.coordinator.identities import people_counter
from ppaas.people.coordinator.parameters import CoordinatorParameters
from ppaas.people.coordinator.people_table import PeopleTable, PersonRecord
from ppaas.people.coordinator.zone_counts import ZoneCounts
from ppaas.people.settings import PeopleSettings
from ppaas.people.tracks.filter_bank import MODELS

# -- parts of a coordinator that its state is made of ------------------------------------------------------------------


class CoordinatorParts(Protocol):
    """A coordinator, as its checkpoint and its message see it; ``Coordinator`` describes the attributes."""

    parameters: CoordinatorParameters
    settings: PeopleSettings
    table: PeopleTable
    robots: Robots
    follow: FollowController
    zones: ZoneCounts
    at: float
    began: float


Array = NDArray[np.float64]

# -- checkpoint of a coordinator ---------------------------------------------------------------------------------------

FORMAT = 1
"""Number of this format; it changes with the fields."""


class _Robot(msgspec.Struct):
    """What a robot's next report goes on from."""

    name: str
    bound: dict[str, int]
    offset: list[float]
    covariance: list[float]


class SavedCoordinator(msgspec.Struct, forbid_unknown_fields=True):
    """State of a coordinator; arrays are bytes of float64."""

    format: int
    at: float
    began: float
    next_id: int
    people: list[PersonRecord]
    means: bytes
    covariances: bytes
    weights: bytes
    robots: list[_Robot]
    orders: list[FollowAssignment]
    given_up: list[tuple[str, int, float]]
    hour: int
    counted: list[tuple[str, int, int]]
    seen: dict[str, list[int]]


def save_state(coordinator: CoordinatorParts) -> bytes:
    """Return the state of a coordinator as bytes."""
    table, zones, bank = coordinator.table, coordinator.zones, coordinator.table.bank
    return msgspec.msgpack.encode(
        SavedCoordinator(
            format=FORMAT,
            at=coordinator.at,
            began=coordinator.began,
            next_id=table.next_id,
            people=table.rows,
            means=bank.means.tobytes(),
            covariances=bank.covariances.tobytes(),
            weights=bank.weights.tobytes(),
            robots=[
                _Robot(name, robot.bound, robot.offset.mean.tolist(), robot.offset.covariance.ravel().tolist())
                for name, robot in coordinator.robots.known.items()
            ],
            orders=list(coordinator.follow.orders.values()),
            given_up=[(robot, person, until) for (robot, person), until in coordinator.follow.given_up.items()],
            hour=zones.hour,
            counted=[(zone, hour, people) for (zone, hour), people in zones.counted.items()],
            seen={zone: sorted(ids) for zone, ids in zones.seen.items()},
        )
    )


def load_state(coordinator: CoordinatorParts, saved: bytes) -> None:
    """Replace the state of a coordinator by a saved one.

    Raises
    ------
    InvalidInput
        The bytes are not such a state; nothing has changed.
    """
    state = _decoded(saved)
    count = len(state.people)
    means = _array(state.means, (count, MODELS, 4))
    covariances = _array(state.covariances, (count, MODELS, 4, 4))
    weights = _array(state.weights, (count, MODELS))
    earlier = {each.name: _earlier(each) for each in state.robots}
    table, zones = coordinator.table, coordinator.zones
    table.bank.means, table.bank.covariances, table.bank.weights = means, covariances, weights
    table.rows, table.next_id = state.people, state.next_id
    table.read()
    coordinator.at, coordinator.began = state.at, state.began
    coordinator.robots.known, coordinator.robots.earlier = {}, earlier
    coordinator.follow.orders = {order.person: order for order in state.orders}
    coordinator.follow.given_up = {(robot, person): until for robot, person, until in state.given_up}
    if coordinator.settings.history:
        zones.hour = state.hour
        zones.counted = {(zone, hour): people for zone, hour, people in state.counted}
        zones.seen = {zone: set(ids) for zone, ids in state.seen.items()}


def _decoded(saved: bytes) -> SavedCoordinator:
    try:
        state = from_msgpack(saved, SavedCoordinator)
    except (msgspec.ValidationError, msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InvalidInput(f"not a checkpoint of a people coordinator: {error}") from error
    if state.format != FORMAT:
        raise InvalidInput(f"checkpoint of a people coordinator has format {state.format}, not {FORMAT}")
    return state


def _array(data: bytes, shape: tuple[int, ...]) -> Array:
    """Return an array of its bytes."""
    if len(data) != 8 * math.prod(shape):
        raise InvalidInput(f"not a checkpoint of a people coordinator: an array does not have the shape {shape}")
    array: Array = np.frombuffer(data).reshape(shape).copy()
    if not np.isfinite(array).all():
        raise InvalidInput("not a checkpoint of a people coordinator: an array is not finite")
    return array


def _earlier(robot: _Robot) -> Earlier:
    if len(robot.offset) != 3 or len(robot.covariance) != 9:
        raise InvalidInput(f"not a checkpoint of a people coordinator: the offset of robot {robot.name!r} is wrong")
    return Earlier(robot.bound, np.array(robot.offset), np.array(robot.covariance).reshape(3, 3))


# -- state as a message ------------------------------------------------------------------------------------------------

MAP = "map"

SHOWN = 10.0
"""Time for which people are in the message after they were seen last, unless they are followed [s]."""


def state_of(coordinator: CoordinatorParts, now: float) -> PeopleState:
    """Return the state of a coordinator at a time [s since the epoch]."""
    counted = [person.id for person in coordinator.table.rows if person.counts for _ in person.seen_by or (None,)]
    return PeopleState(
        header=Header(stamp=Time.of(now), frame_id=MAP),
        count=people_counter(counted),
        people=_people(coordinator, now),
        orders=[
            FollowOrder(order.robot, person, order.cost, Time.of(order.since), order.reason)
            for person, order in sorted(coordinator.follow.orders.items())
        ],
        robots=_robots(coordinator, now),
        rule=coordinator.settings.rule,
    )


def _people(coordinator: CoordinatorParts, now: float) -> list[TrackedPerson]:
    table, names = coordinator.table, coordinator.settings.names
    followed = coordinator.follow.orders
    people = []
    rows = zip(
        table.rows, table.positions.tolist(), table.velocities.tolist(), table.covariances.reshape(-1, 4).tolist(),
        strict=True,
    )  # fmt: skip
    for person, (x, y), (vx, vy), covariance in rows:
        shown = person.counts or person.id in followed or now - person.last_seen <= SHOWN
        if not (person.confirmed and shown and (person.counts or person.state != "seen")):
            continue
        people.append(
            TrackedPerson(
                person.id,
                Point(x, y),
                Point(0.0, 0.0) if person.state == LOST else Point(vx, vy),
                covariance,
                names.get(str(person.id), ""),
                person.state,
                list(person.seen_by.values()),
                Time.of(person.first_seen),
                Time.of(person.last_seen),
                person.group,
            )
        )
    return people


def _robots(coordinator: CoordinatorParts, now: float) -> list[GroupRobot]:
    robots = []
    for name, robot in sorted(coordinator.robots.known.items()):
        reason = robot.reason(now, 3.0 * coordinator.parameters.report_timeout)
        pose = robot.pose
        where, deviation = Point(float(pose.x), float(pose.y)), float(robot.deviation)
        robots.append(GroupRobot(name, where, deviation, len(robot.report.ids), not reason, reason))
    return robots
