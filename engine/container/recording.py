"""Adds the node ``recorder`` to the clone of a robot, and connects it with the machine."""

from typing import Any

import msgspec

from engine.container.current_map import CurrentMap
from engine.container.machine_client import MachineClient
from engine.protocols.machine_link import RecorderTold
from engine.specs.containers import RobotConfig
from ppaas import __version__
from ppaas.errors import PPaaSError
from ppaas.maps.new_map import NEW
from ppaas.messages.base.rosapi import GetParamRequest, GetParamResponse
from ppaas.nodes.base import Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.recorder.node import RecorderNode
from ppaas.recording.batches import About
from ppaas.recording.parameters import NAME, recorder_parameters

MOST_WAITING = 8 << 20
"""Bytes queued for a slow machine above which batches are dropped."""


class RecordingLink:
    """Connection between the recorder of a clone and the machine, which is connected after the clone was built.

    Parameters
    ----------
    graph : Graph
        Graph with the clone; the node is added to it.
    robot : RobotConfig
        Configuration of the robot.
    current : CurrentMap
        Its map, which may be replaced later.
    cores : float
        Size of the container.

    Raises
    ------
    InvalidParameter
        A parameter of the recorder in the robot's file is invalid.
    """

    def __init__(self, graph: Graph, robot: RobotConfig, current: CurrentMap, cores: float) -> None:
        self._graph, self._current, self._cores = graph, current, cores
        self._robot = msgspec.structs.replace(robot, urdf_text=b"")  # it is recorded as robot_description
        self._machine: MachineClient | None = None
        self._in_use: dict[str, Any] | None = None
        parameters = recorder_parameters(robot.parameters.get(NAME, {}))
        self._node = graph.add(lambda context: RecorderNode(context, graph, parameters, self._about, self._hand_over))

    def connect(self, machine: MachineClient) -> None:
        """Hand batches to a machine from now on."""
        self._machine = machine

    def told(self, frame: RecorderTold) -> None:
        """Pass on an answer of the recorder of the machine."""
        self._node.told(frame.problem, forgotten=frame.forgotten, lost=frame.lost)

    def _hand_over(self, batch: bytes) -> bool:
        machine = self._machine
        if machine is None or machine.waiting > MOST_WAITING:
            return False
        machine.record(batch)
        return True

    def _about(self) -> About:
        robot, on = self._robot, self._current.spec.map
        if self._in_use is None:
            self._in_use = self._parameters()
        return About(
            robot=robot.id,
            software=__version__,
            map=on.id,
            map_version=on.version,
            file={
                "map": f"{NEW}{robot.new_map}" if robot.new_map else on.id,
                "model": robot.model,
                "initial_pose": list(robot.initial_pose),
                "cores": self._cores,
                "base_global_planner": robot.base_global_planner,
                "base_local_planner": robot.base_local_planner,
                "parameters": robot.parameters,
            },
            parameters=self._in_use,
        )

    def _parameters(self) -> dict[str, Any]:
        found: dict[str, Any] = {}

        def reply(answer: Payload | PPaaSError) -> None:
            if isinstance(answer, GetParamResponse):
                found.update(msgspec.json.decode(answer.value))

        self._graph.call("rosapi/get_param", GetParamRequest("/"), reply)
        return found
