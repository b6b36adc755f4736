"""Start of a container: time from opening a robot's WebSocket to the first message and the first path."""

import asyncio

from rich.progress import Progress

from benchmarks.engine import baselines
from benchmarks.engine.first_answer import MAP, FirstPathQuestion, opened, prepared
from benchmarks.engine.options import PAUSES, READY_LIMIT_MS, EngineOptions
from benchmarks.engine.samples import median_and_p99
from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure
from ppaas.clock import monotonic

PART = "ready"
OPENS, OPENS_WITH_PAUSES, QUICK = 100, 20, 3

FIRST_MESSAGE = '{"op":"subscribe","topic":"tf_static"}'
"""Subscription to a latched topic, which the clone answers at once."""


async def measure(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Open robots in turns with empty Python processes; the first robot is a warm-up, as the map is new for it."""
    pause = PAUSES.get(options.runtime, 0.0)
    opens = options.of(OPENS_WITH_PAUSES if pause else OPENS, QUICK)
    question = await prepared(site.target)
    opened, started = [], []
    for number in progress.track(range(opens + 1), description="opening robots"):
        opened.append(await _open(site, f"bench-ready-{number}", question))
        started.append(await baselines.python())
        await asyncio.sleep(pause)
    ready, answered = zip(*opened[1:], strict=True)
    paced = f", one each {pause:g} s" if pause else ""
    limit, how = READY_LIMIT_MS[options.runtime], f"{options.runtime}{paced}; from opening the socket to"
    return [
        *median_and_p99(PART, "container ready", ready, limit=limit, note=f"{how} the clone's first message"),
        *median_and_p99(PART, "first path", answered, limit=limit, note=f"{how} a path by its planner"),
        *baselines.figures(PART, started, await baselines.forks(opens)),
    ]


async def _open(site: EngineSite, robot: str, question: FirstPathQuestion) -> tuple[float, float]:
    """Return the times until the first message and until the path [s]."""
    url = await site.target.register(robot, MAP, question.start)
    began = monotonic()
    async with opened(url) as socket:
        await socket.send(FIRST_MESSAGE)
        await socket.recv()
        heard = monotonic()
        await question.ask(socket)
        return heard - began, monotonic() - began
