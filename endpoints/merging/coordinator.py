"""Coordinator: joins the maps of robots that make maps of one name, while they make them."""

import asyncio
import base64
import contextlib
import json
import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.concurrency import run_in_threadpool

from endpoints.rest.maps.map_programs import MAKE_SECONDS, run_program
from endpoints.services.joint_maps import Join, RobotMap, shown_to
from endpoints.services.robot_files import whole_file
from endpoints.services.services import Services
from engine.service.views import MappingRobot
from engine.specs.joint_maps import joint_map_owner
from ppaas.errors import PPaaSError, Unavailable
from ppaas.maps.new_map import new_map_id
from ppaas.messages.slam_toolbox import UseJointMapRequest
from storage.disk_errors import disk_errors
from storage.staged_uploads import temporary_folder

if TYPE_CHECKING:
    from endpoints.merging import join_program  # noqa: F401 - the program named below

logger = logging.getLogger(__name__)

_PROGRAM = "endpoints.merging.join_program"

PERIOD = 3.0
"""Time between two looks at the maps of the robots [s]."""

ANSWER_TIMEOUT = 5.0
"""Time within which a robot's clone reports the size of its map [s]."""

PAGE = 3 << 18
"""Size of a page of a joint map [bytes]; 1 MiB in base64."""

Program = Callable[[Sequence[Sequence[bytes]]], bytes]
"""Joins the files of groups of pose graphs; see `join_in_process`."""


class JointMapCoordinator:
    """Looks for robots whose maps may be joined, and joins one set of maps after the other.

    What robots have mapped stays in their clones: a merge that ends early, with this process or with a container, is
    simply repeated.

    Parameters
    ----------
    services : Services
    join : callable
        Joins the files of pose graphs; it blocks.
    """

    def __init__(self, services: Services, join: Program | None = None) -> None:
        self._map_store = services.map_store
        self._cloud, self._maps, self._heavy = services.cloud, services.joint_maps, services.heavy_work
        self._join = join or join_in_process

    async def run(self) -> None:
        """Join maps until cancelled."""
        while True:
            try:
                await self.step()
            except Exception:
                logger.exception("joining the maps of robots failed; it is tried again")
            await asyncio.sleep(PERIOD)

    async def step(self) -> Join | None:
        """Look at the maps of all robots, and join those that are due; return them."""
        self._maps.report(await self._reports())
        join = self._maps.next_join()
        if join is not None:
            await self._execute(join)
        return join

    async def _reports(self) -> dict[str, list[RobotMap]]:
        """Return the maps of robots, by the names of joint maps that have several robots."""
        named: dict[str, list[MappingRobot]] = {}
        for robot in await run_in_threadpool(self._permitted, self._cloud.mapping_robots()):
            named.setdefault(robot.joint_map, []).append(robot)
        several = {name: robots for name, robots in named.items() if len(robots) > 1}
        found = await asyncio.gather(*(self._report(robot) for robots in several.values() for robot in robots))
        maps: dict[str, list[RobotMap]] = {name: [] for name in several}
        for robot, report in zip((each for robots in several.values() for each in robots), found, strict=True):
            if report is not None:
                maps[robot.joint_map].append(report)
        return maps

    def _permitted(self, robots: list[MappingRobot]) -> list[MappingRobot]:
        """Return the robots without those of users with whom the published map is not shared any more; may block."""
        kept: list[MappingRobot] = []
        for robot in robots:
            name, _, owner = robot.joint_map.partition("@")
            new = new_map_id(name)
            if robot.user == owner or (new and joint_map_owner(self._map_store, robot.user, new) == owner):
                kept.append(robot)
        return kept

    async def _report(self, robot: MappingRobot) -> RobotMap | None:
        """Return the map of a robot; None if it has none that may be joined, or its clone does not answer."""
        with contextlib.suppress(PPaaSError, TimeoutError):
            async with asyncio.timeout(ANSWER_TIMEOUT):
                numbers = await self._cloud.robot_map(robot.user, robot.robot, -1)
            if numbers.frame:
                return RobotMap(robot.user, robot.robot, numbers.frame, numbers.key_frames, numbers.scans)
        return None

    async def _execute(self, join: Join) -> None:
        try:
            files = [await asyncio.gather(*map(self._fetch, group)) for group in join.groups]
        except PPaaSError as error:
            self._refused(join, error)
            return
        try:
            async with self._heavy.turn(join.owner):
                joint = await run_in_threadpool(self._join, files)
        except PPaaSError as error:
            self._refused(join, error, final=True)
            return
        sent = await asyncio.gather(*(self._send(robot, joint, join) for robot in join.robots))
        errors = [outcome for outcome in sent if isinstance(outcome, PPaaSError)]
        if errors:
            self._refused(join, errors[0], final=not all(isinstance(error, Unavailable) for error in errors))
            return
        sizes = [outcome for outcome in sent if isinstance(outcome, int)]
        self._maps.done(join, sum(sizes))
        logger.info("maps of %s are joined: %d key frames", _names(join), max(sizes))

    def _refused(self, join: Join, error: PPaaSError, *, final: bool = False) -> None:
        """Note that maps are not joined; a final reason holds until they have grown."""
        logger.info("maps of %s are not joined: %s", _names(join), error)
        size = sum(robot.key_frames for robot in join.robots) if final else 0
        self._maps.done(join, size, str(error))

    async def _fetch(self, robot: RobotMap) -> bytes:
        """Return the pose graph of a robot."""
        first = await self._cloud.robot_map(robot.user, robot.robot, 0)
        return await whole_file(
            first, lambda offset: self._cloud.robot_map(robot.user, robot.robot, offset), robot.robot
        )

    async def _send(self, robot: RobotMap, joint: bytes, join: Join) -> int | PPaaSError:
        """Send a joint map to one of its robots; return the number of its key frames then, or the error.

        A robot that does not take it keeps its own map. The next join finds the scans that both have, without a search.
        """
        others, key_frames = [shown_to(robot.user, other) for other in join.robots if other is not robot], 0
        try:
            for at in range(0, len(joint), PAGE):
                page = base64.b64encode(joint[at : at + PAGE]).decode()
                request = UseJointMapRequest(at, len(joint), page, others)
                key_frames = (await self._cloud.use_joint_map(robot.user, robot.robot, request)).key_frames
        except PPaaSError as error:
            return error
        return key_frames


def _names(join: Join) -> str:
    return " and ".join(f"{robot.user}/{robot.robot}" for robot in join.robots)


def join_in_process(groups: Sequence[Sequence[bytes]]) -> bytes:
    """Join pose graphs in a process of its own; blocks.

    Parameters
    ----------
    groups : sequence of sequence of bytes
        Files of pose graphs; see ``ppaas.mapping.merging.joint_map.join_maps``.

    Returns
    -------
    bytes
        File of the joint map.

    Raises
    ------
    PPaaSError
        The error of the merge; ``QuotaExceeded`` if it ran out of memory, ``Unavailable`` if out of time.
    """
    with temporary_folder() as folder:
        paths: list[list[str]] = []
        with disk_errors(folder):
            for number, group in enumerate(groups):
                paths.append([str(folder / f"{number}-{of}") for of in range(len(group))])
                for path, file in zip(paths[-1], group, strict=True):
                    Path(path).write_bytes(file)
        to = folder / "joint"
        run_program(_PROGRAM, [json.dumps(paths), str(to)], "the maps could not be joined", MAKE_SECONDS)
        return to.read_bytes()
