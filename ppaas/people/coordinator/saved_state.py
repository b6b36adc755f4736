"""Checkpoint of a coordinator: identities, filters, orders and counts as bytes."""

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.decoding import from_msgpack
from ppaas.errors import InvalidInput
from ppaas.people.coordinator.follow_controller import Order
from ppaas.people.coordinator.parts import CoordinatorParts
from ppaas.people.coordinator.people_table import PersonRecord
from ppaas.people.coordinator.robots.group import Earlier
from ppaas.people.tracks.filter_bank import MODELS

Array = NDArray[np.float64]

FORMAT = 1
"""Number of this format; it changes with the fields."""


class _Robot(msgspec.Struct):
    """What a robot's next report goes on from."""

    name: str
    bound: dict[str, int]
    offset: list[float]
    covariance: list[float]


class _Saved(msgspec.Struct, forbid_unknown_fields=True):
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
    orders: list[Order]
    given_up: list[tuple[str, int, float]]
    hour: int
    counted: list[tuple[str, int, int]]
    seen: dict[str, list[int]]


def save_state(coordinator: CoordinatorParts) -> bytes:
    """Return the state of a coordinator as bytes."""
    table, zones, bank = coordinator.table, coordinator.zones, coordinator.table.bank
    return msgspec.msgpack.encode(
        _Saved(
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


def _decoded(saved: bytes) -> _Saved:
    try:
        state = from_msgpack(saved, _Saved)
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
