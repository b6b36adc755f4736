"""Replays a recording: sends what was sent, at the recorded times, to a fresh clone."""

import asyncio
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from ppaas.maps.formats.map_files import save_map
from ppaas.messages.base.message import Message
from ppaas.nodes import topics
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from robots.demo.cloud_process import CloudProcess
from robots.replay.outcomes import COMPARED, Comparison, Outcomes, compare
from robots.replay.recorded import Recorded

NEWEST_ONLY = frozenset({topics.SCAN.name, topics.ODOM.name})
"""Topics of which a message replaces the one before that still waits to be sent."""

SETTLE = 2.0
"""Time after the last message for what the clone still has to say [s]."""


@dataclass(frozen=True, slots=True)
class ReplayOptions:
    """Settings of a replay.

    Parameters
    ----------
    path : Path
        The recording.
    robot : str
        Id of the robot in the cloud.
    speed : float
        Factor on the recorded speed.
    until : float, optional
        Time in the recording at which it ends [s].
    file : RobotFile, optional
        Robot file in place of the recording's.
    map : str
        Id of a map of the cloud in place of the recording's; empty for that.
    renamed : mapping of str to str
        Names of topics in the file, and the clone's names in their place.
    cloud : tuple of str, optional
        URL and token of a cloud to join; without it, one is started and ends with the replay.
    """

    path: Path
    robot: str = "replay"
    speed: float = 1.0
    until: float | None = None
    file: RobotFile | None = None
    map: str = ""
    renamed: Mapping[str, str] = field(default_factory=dict)
    cloud: tuple[str, str] | None = None


@dataclass(frozen=True, slots=True)
class ReplayReport:
    """Messages that were sent, and how the clone's answers differ from the recorded ones."""

    recorded: Recorded
    sent: int
    comparison: Comparison


async def replay(options: ReplayOptions, say: Callable[[str], None]) -> ReplayReport:
    """Replay a recording.

    Parameters
    ----------
    options : ReplayOptions
    say : callable
        Called with what is done.

    Raises
    ------
    InvalidInput
        The file cannot be read, or has nothing to send.
    PPaaSError
        The cloud does not start, or refuses the map or the robot.
    """
    recorded = await asyncio.to_thread(Recorded(options.path, options.renamed).read)
    say(_summary(recorded))
    async with AsyncExitStack() as stack:
        if options.cloud is None:
            say("starting a cloud")
            cloud = await stack.enter_async_context(CloudProcess())
            url = cloud.ready.url
            token = (await RestClient(url).login(cloud.ready.admin_user, cloud.password)).token
        else:
            url, token = options.cloud
        rest = RestClient(url, token)
        await _set_up(rest, recorded, options, say)
        replayed, sent = await _send(url, token, recorded, options, say)
    return ReplayReport(recorded, sent, compare(recorded.outcomes, replayed))


def _summary(recorded: Recorded) -> str:
    counts = ", ".join(f"{topic} {count}" for topic, count in recorded.counts.most_common())
    return "; ".join((f"{recorded.path}: {recorded.seconds:.1f} s to send ({counts})", *recorded.notes))


async def _set_up(rest: RestClient, recorded: Recorded, options: ReplayOptions, say: Callable[[str], None]) -> None:
    """Publish the recorded map, and put the robot on it; without a map, the robot makes one."""
    file = options.file or recorded.file or RobotFile(map="new:replay")
    chosen = options.map or (await _published(rest, recorded, options) if recorded.grid is not None else "new:replay")
    pose = recorded.initial_pose or file.initial_pose
    await rest.put_robot(options.robot, msgspec.structs.replace(file, map=chosen, initial_pose=pose))
    say(f"robot {options.robot} on map {chosen} from {pose[0]:.2f}, {pose[1]:.2f}, {pose[2]:.2f}")


async def _published(rest: RestClient, recorded: Recorded, options: ReplayOptions) -> str:
    assert recorded.grid is not None
    name = f"{options.robot}-map"
    yaml, image = await asyncio.to_thread(save_map, recorded.grid, "map.pgm")
    await rest.upload_map(name, yaml, image)
    return name


async def _send(
    url: str, token: str, recorded: Recorded, options: ReplayOptions, say: Callable[[str], None]
) -> tuple[Outcomes, int]:
    """Send the messages at their times; return what the clone said, and their number."""
    loop, replayed, sent = asyncio.get_running_loop(), Outcomes(), 0
    async with RobotClient(url, robot=options.robot, token=token) as client:
        began = loop.time()

        def hear(topic: str) -> Callable[[Message], None]:
            return lambda message: replayed.take(topic, message, (loop.time() - began) * options.speed)

        for topic in COMPARED:
            await client.subscribe(topic, topics.TOPICS[topic].type, hear(topic))
        began = loop.time()
        for message in recorded.inputs():
            if options.until is not None and message.after > options.until:
                break
            await asyncio.sleep(max(began + message.after / options.speed - loop.time(), 0.0))
            await client.publish(message.topic, message.message, newest_only=message.topic in NEWEST_ONLY)
            sent += 1
        await asyncio.sleep(SETTLE)
    say(f"sent {sent} messages in {loop.time() - began:.1f} s")
    return replayed, sent
