"""Coordinator: joins the maps of robots that make maps of one name, while they make them."""

import asyncio
import base64
import contextlib
import json
import logging
from collections.abc import AsyncIterator, Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.concurrency import run_in_threadpool

from endpoints.resources.joint_maps import MapJoin, RobotMap, shown_to
from endpoints.resources.services import Services
from endpoints.rest.maps.map_programs import MAKE_SECONDS, run_program
from engine.control.views import MappingRobot
from engine.processes.background import repeat
from engine.specs.robot_maps import joint_map_owner
from ppaas.errors import NotPermitted, PPaaSError, Unavailable
from ppaas.maps.new_map import new_map_id
from ppaas.messages.slam_toolbox import UseJointMapRequest
from storage.store_errors import disk_errors
from storage.temporary import temporary_folder

if TYPE_CHECKING:
    from endpoints.merging import join_program  # noqa: F401 - the program named below

logger = logging.getLogger(__name__)

_PROGRAM = "endpoints.merging.join_program"

PERIOD = 3.0
"""Time between two looks at the maps of the robots [s]."""

ANSWER_TIMEOUT = 5.0
"""Time within which a robot's clone reports the size of its map [s]."""

TRANSFER_TIMEOUT = 60.0
"""Time limit of the transfer of a map from or to a robot [s], since joins of other robots wait meanwhile."""

TURN_TIMEOUT = 60.0
"""Time limit of the wait for a turn of the owner's heavy work [s], for the same reason."""

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
        self._cloud, self._posegraphs = services.cloud, services.posegraphs
        self._maps, self._heavy = services.joint_maps, services.heavy_work
        self._join = join or join_in_process

    async def run(self) -> None:
        """Join maps until cancelled."""
        await repeat(self.step, PERIOD)

    async def step(self) -> MapJoin | None:
        """Look at the maps of all robots, and join those that are due; return them."""
        self._maps.report(await self._reports())
        join = self._maps.next_join()
        if join is not None:
            try:
                await self._execute(join)
            except Exception:
                self._maps.done(join, join.key_frames, "the maps could not be joined: an internal error")
                raise
        return join

    async def _reports(self) -> dict[str, list[RobotMap]]:
        named: dict[str, list[MappingRobot]] = {}
        for robot in await run_in_threadpool(self._permitted, await self._cloud.maps.mapping_robots()):
            named.setdefault(robot.joint_map, []).append(robot)
        several = {name: robots for name, robots in named.items() if len(robots) > 1}
        found = await asyncio.gather(*(self._report(robot) for robots in several.values() for robot in robots))
        maps: dict[str, list[RobotMap]] = {name: [] for name in several}
        for robot, report in zip((each for robots in several.values() for each in robots), found, strict=True):
            if report is not None:
                maps[robot.joint_map].append(report)
        return maps

    def _permitted(self, robots: list[MappingRobot]) -> list[MappingRobot]:
        """Return the robots whose users own the published map, or may still use it; may block."""
        return [robot for robot in robots if self._may_join(robot.user, robot.joint_map)]

    def _may_join(self, user: str, joint_map: str) -> bool:
        name, _, owner = joint_map.partition("@")
        new = new_map_id(name)
        return user == owner or (new is not None and joint_map_owner(self._map_store, user, new) == owner)

    async def _report(self, robot: MappingRobot) -> RobotMap | None:
        """Return the map of a robot; None if it has none that may be joined, or its clone does not answer."""
        with contextlib.suppress(PPaaSError, TimeoutError):
            async with asyncio.timeout(ANSWER_TIMEOUT):
                numbers = await self._cloud.nodes.map(robot.user, robot.robot, -1)
            if numbers.frame:
                return RobotMap(robot.user, robot.robot, numbers.frame, numbers.key_frames, numbers.scans)
        return None

    async def _execute(self, join: MapJoin) -> None:
        try:
            files = [await asyncio.gather(*map(self._fetch, group)) for group in join.groups]
            joint = await self._joined(join, files)
        except PPaaSError as error:
            self._refused(join, error)
            return
        if isinstance(joint, PPaaSError):
            self._refused(join, joint, final=True)
            return
        sent = await asyncio.gather(*(self._send(robot, joint, join) for robot in join.robots))
        errors = [outcome for outcome in sent if isinstance(outcome, PPaaSError)]
        if errors:
            self._refused(join, errors[0], final=not all(isinstance(error, Unavailable) for error in errors))
            return
        sizes = [outcome for outcome in sent if isinstance(outcome, int)]
        self._maps.done(join, sum(sizes))
        logger.info("maps of %s are joined: %d key frames", _names(join), max(sizes))

    async def _joined(self, join: MapJoin, files: Sequence[Sequence[bytes]]) -> bytes | PPaaSError:
        """Return the joint map of files, or why they cannot be joined.

        Raises
        ------
        Unavailable
            The turn of the owner did not come.
        NotPermitted
            The published map is not shared any more.
        """
        try:
            async with asyncio.timeout(TURN_TIMEOUT) as limit, self._heavy.turn(join.owner):
                limit.reschedule(None)
                return await run_in_threadpool(self._permitted_join, join, files)
        except TimeoutError as error:
            raise Unavailable("the maps could not be joined yet: other work of their owner takes long") from error

    def _permitted_join(self, join: MapJoin, files: Sequence[Sequence[bytes]]) -> bytes | PPaaSError:
        """Join files, and check after that time that all users may still have the result; blocks."""
        try:
            joint = self._join(files)
        except PPaaSError as error:
            return error
        for robot in join.robots:
            if not self._may_join(robot.user, join.joint_map):
                raise NotPermitted(f"the published map is no longer shared with {robot.user!r}")
        return joint

    def _refused(self, join: MapJoin, error: PPaaSError, *, final: bool = False) -> None:
        """Note that maps are not joined; a final reason holds until they have grown."""
        logger.info("maps of %s are not joined: %s", _names(join), error)
        self._maps.done(join, join.key_frames if final else 0, str(error))

    async def _fetch(self, robot: RobotMap) -> bytes:
        """Return the pose graph of a robot; raises ``Unavailable`` if it does not come in time."""
        async with _transfer(robot):
            return (await self._posegraphs.fetch(self._cloud.nodes, robot.user, robot.robot))[0]

    async def _send(self, robot: RobotMap, joint: bytes, join: MapJoin) -> int | PPaaSError:
        """Send a joint map to one of its robots; return the number of its key frames then, or the error.

        A robot that does not take it keeps its own map. The next join finds the scans that both have, without a search.
        """
        others, key_frames = [shown_to(robot.user, other) for other in join.robots if other is not robot], 0
        try:
            async with _transfer(robot):
                for at in range(0, len(joint), PAGE):
                    page = base64.b64encode(joint[at : at + PAGE]).decode()
                    request = UseJointMapRequest(at, len(joint), page, others)
                    key_frames = (await self._cloud.nodes.use_joint_map(robot.user, robot.robot, request)).key_frames
        except PPaaSError as error:
            return error
        return key_frames


@contextlib.asynccontextmanager
async def _transfer(robot: RobotMap) -> AsyncIterator[None]:
    """Limit the time of a transfer; raises ``Unavailable`` when it is over."""
    try:
        async with asyncio.timeout(TRANSFER_TIMEOUT):
            yield
    except TimeoutError as error:
        raise Unavailable(
            f"the map of robot {robot.robot!r} was not transferred within {TRANSFER_TIMEOUT:g} s: it is tried again"
        ) from error


def _names(join: MapJoin) -> str:
    return " and ".join(f"{robot.user}/{robot.robot}" for robot in join.robots)


def join_in_process(groups: Sequence[Sequence[bytes]]) -> bytes:
    """Join pose graphs in a separate process; blocks.

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
