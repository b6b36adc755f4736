"""free_fleet of Open-RMF as it speaks to a robot over Zenoh, with types that Cyclone DDS codes itself.

It listens to tf and battery of a robot below its name, sends goals with ids that it makes, asks for results, and
cancels all goals at once.
"""

import os
from dataclasses import dataclass
from typing import Any, TypeVar

import zenoh
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int16, int32, sequence, uint8, uint32

S = TypeVar("S", bound=IdlStruct)


@dataclass
class Time(IdlStruct, typename="Time"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="Header"):
    stamp: Time
    frame_id: str


@dataclass
class Vector(IdlStruct, typename="Vector"):
    x: float64
    y: float64
    z: float64


@dataclass
class Turn(IdlStruct, typename="Turn"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Transform(IdlStruct, typename="Transform"):
    header: Header
    child_frame_id: str
    translation: Vector
    rotation: Turn


@dataclass
class Transforms(IdlStruct, typename="Transforms"):
    transforms: sequence[Transform]


@dataclass
class Battery(IdlStruct, typename="Battery"):
    header: Header
    voltage: float32
    temperature: float32
    current: float32
    charge: float32
    capacity: float32
    design_capacity: float32
    percentage: float32


@dataclass
class Goal(IdlStruct, typename="Goal"):
    goal_id: array[uint8, 16]
    header: Header
    position: Vector
    orientation: Turn
    behavior_tree: str


@dataclass
class Accepted(IdlStruct, typename="Accepted"):
    accepted: bool
    stamp: Time


@dataclass
class GoalId(IdlStruct, typename="GoalId"):
    goal_id: array[uint8, 16]


@dataclass
class Result(IdlStruct, typename="Result"):
    status: int8


@dataclass
class Feedback(IdlStruct, typename="Feedback"):
    goal_id: array[uint8, 16]
    header: Header
    position: Vector
    orientation: Turn
    navigation_time: Time
    estimated_time_remaining: Time
    number_of_recoveries: int16
    distance_remaining: float32


@dataclass
class Cancel(IdlStruct, typename="Cancel"):
    goal_id: array[uint8, 16]
    stamp: Time


class FreeFleetPeer:
    """Adapter of one robot.

    Parameters
    ----------
    endpoint : str
        Endpoint of the router.
    robot : str
        Name of the robot in RMF.
    """

    def __init__(self, endpoint: str, robot: str) -> None:
        config = zenoh.Config()
        for key, value in (("mode", '"client"'), ("connect/endpoints", f'["{endpoint}"]')):
            config.insert_json5(key, value)
        self._session, self._robot = zenoh.open(config), robot
        self.transforms: list[Transform] = []
        self.charges: list[float] = []
        self.distances: list[float] = []
        self._kept = [
            self._session.declare_subscriber(f"{robot}/{topic}", heard)
            for topic, heard in (
                ("tf", self._on_tf),
                ("battery_state", self._on_battery),
                ("navigate_to_pose/_action/feedback", self._on_feedback),
            )
        ]

    def _on_tf(self, sample: zenoh.Sample) -> None:
        self.transforms += Transforms.deserialize(sample.payload.to_bytes()).transforms

    def _on_battery(self, sample: zenoh.Sample) -> None:
        self.charges.append(Battery.deserialize(sample.payload.to_bytes()).percentage)

    def _on_feedback(self, sample: zenoh.Sample) -> None:
        self.distances.append(Feedback.deserialize(sample.payload.to_bytes()).distance_remaining)

    def _ask(self, service: str, request: IdlStruct, answer: type[S], timeout: float) -> S | None:
        """Return the answer of a service; None if there is none in time. It blocks."""
        key = f"{self._robot}/navigate_to_pose/_action/{service}"
        for reply in self._session.get(key, payload=request.serialize(), timeout=timeout):
            if reply.ok:
                return answer.deserialize(reply.ok.payload.to_bytes())
        return None

    def go(self, x: float, y: float) -> Any:
        """Send a goal; return its id, None if it is not accepted. It blocks."""
        identity = list(os.urandom(16))
        header, turn = Header(Time(0, 0), "map"), Turn(0.0, 0.0, 0.0, 1.0)
        answer = self._ask("send_goal", Goal(identity, header, Vector(x, y, 0.0), turn, ""), Accepted, 10.0)
        return identity if answer is not None and answer.accepted else None

    def result(self, identity: Any, timeout: float = 1.0) -> int | None:
        """Return the status of a goal that has ended; None while it has not. It blocks."""
        answer = self._ask("get_result", GoalId(identity), Result, timeout)
        return None if answer is None else int(answer.status)

    def stop(self) -> int | None:
        """Cancel all goals; return the code. It blocks."""
        answer = self._ask("cancel_goal", Cancel([0] * 16, Time(0, 0)), Result, 10.0)
        return None if answer is None else int(answer.status)

    def close(self) -> None:
        self._session.close()
