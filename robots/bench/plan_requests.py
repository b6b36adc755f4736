"""How much a plan over the wire takes beyond the planning itself, beside servers that only echo."""

import asyncio
import contextlib
import http.client
import json
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from urllib.parse import urlsplit

import msgspec
from rich.progress import Progress
from websockets.asyncio.client import connect

from ppaas.clock import monotonic
from ppaas.costmap.build import build_layers
from ppaas.geometry import Pose2D
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap
from ppaas.planners.base import PlanRequest
from ppaas.planners.dijkstra import Dijkstra
from robots.bench.figures import Figure, median_of
from robots.bench.target import Target
from robots.sim.goals import CoursePlanner, GoalRules

PART = "plans"
MAP = "bench-plans"
ROBOT = "bench-asker"
REQUESTS, QUICK = 200, 20
WARM = 10
"""Requests before the first that counts."""

LIMIT_MS = 1.0

Ask = Callable[[], Awaitable[float]]
"""Asks once; returns the seconds that the planner says it took."""


async def measure(target: Target, progress: Progress, quick: bool) -> list[Figure]:
    """Ask for the same path in all ways, one after the other, again and again."""
    grid = warehouse(seed=1)
    start, goal = ends(grid)
    await target.publish(MAP, grid)
    url = await target.register(ROBOT, MAP, start)
    async with contextlib.AsyncExitStack() as stack:
        socket = await stack.enter_async_context(connect(f"{url}&role=operator", max_size=None, compression=None))
        frame = socket_request(start, goal)
        await socket.send(frame)
        answer = str(await socket.recv())
        poses = answer.count('"position"')
        body = json.dumps({"start": start, "goal": goal}).encode()
        rest = stack.enter_context(contextlib.closing(RestAsker(target.url, target.token, f"/v1/maps/{MAP}/plans")))
        rest_size = len(rest.exchange(body))
        plain = await stack.enter_async_context(echo("websockets", len(answer)))
        fast = await stack.enter_async_context(echo("fastapi", rest_size))
        plain_socket = await stack.enter_async_context(connect(f"ws://{plain}", max_size=None, compression=None))
        fast_rest = stack.enter_context(contextlib.closing(RestAsker(f"http://{fast}", "none", "/")))
        ways: dict[str, Ask] = {
            "planner": in_process(grid, start, goal),
            "ws": lambda: _ask_socket(socket, frame),
            "rest": lambda: _ask_rest(rest, body),
            "ws echo": lambda: _ask_socket(plain_socket, frame),
            "rest echo": lambda: _ask_rest(fast_rest, body),
        }
        samples = await sample(ways, QUICK if quick else REQUESTS, progress)
    return figures(samples, poses, len(answer), rest_size)


def ends(grid: GridMap) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return a start and a goal that are far apart."""
    rules = GoalRules(shortest=0.8, preferred=0.9)
    course = CoursePlanner(grid, 1, rules).choose(1, 1)[0]
    (a, b) = course.start, course.goals[0]
    return (a.x, a.y, a.theta), (b.x, b.y, b.theta)


async def sample(ways: dict[str, Ask], count: int, progress: Progress) -> dict[str, list[tuple[float, float]]]:
    """Return (seconds in all, seconds of the planner) of each way, asked in turn so that all see the same machine."""
    samples: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    for number in progress.track(range(count + WARM), description="plan requests"):
        for name, ask in ways.items():
            began = monotonic()
            planning = await ask()
            if number >= WARM:
                samples[name].append((monotonic() - began, planning))
    return samples


def figures(samples: dict[str, list[tuple[float, float]]], poses: int, ws_size: int, rest_size: int) -> list[Figure]:
    """Return what the samples say."""
    total = {name: [all_ for all_, _ in taken] for name, taken in samples.items()}
    rest_planner = [planning for _, planning in samples["rest"]]
    # make_plan tells no time: the container that was asked just after took as long for the same path.
    ws_more = [seconds - planning for seconds, planning in zip(total["ws"], rest_planner, strict=True)]
    rest_more = [all_ - planning for all_, planning in samples["rest"]]
    return [
        median_of(PART, "planner, called in this process", total["planner"], note=f"{poses} poses"),
        median_of(PART, "planner, in its container", rest_planner, note="by its own word"),
        median_of(PART, "WebSocket, beyond it", ws_more, limit=LIMIT_MS, note=f"make_plan, {ws_size:,} bytes"),
        median_of(PART, "websockets, echo", total["ws echo"], yardstick=True, note="the same bytes"),
        median_of(PART, "REST, beyond its planner's time", rest_more, limit=LIMIT_MS, note=f"{rest_size:,} bytes"),
        median_of(PART, "FastAPI, echo", total["rest echo"], yardstick=True, note="the same bytes"),
    ]


# -- the ways ----------------------------------------------------------------------------------------------------------


def in_process(grid: GridMap, start: tuple[float, float, float], goal: tuple[float, float, float]) -> Ask:
    """Return what plans here, on the same costs as a container does."""
    costmap, planner = build_layers(grid).costmap, Dijkstra()
    request = PlanRequest(Pose2D(*start), Pose2D(*goal))

    async def ask() -> float:
        return planner.plan(costmap, request).seconds

    return ask


def socket_request(start: tuple[float, float, float], goal: tuple[float, float, float]) -> str:
    """Return the frame of a call of ``make_plan``."""

    def stamped(pose: tuple[float, float, float]) -> dict[str, object]:
        position = {"x": pose[0], "y": pose[1]}
        return {"header": {"frame_id": "map"}, "pose": {"position": position, "orientation": {"z": 0.0, "w": 1.0}}}

    arguments = {"start": stamped(start), "goal": stamped(goal)}
    return json.dumps({"op": "call_service", "id": "1", "service": "/move_base/make_plan", "args": arguments})


async def _ask_socket(socket: object, frame: str) -> float:
    await socket.send(frame)  # type: ignore[attr-defined]
    await socket.recv()  # type: ignore[attr-defined]
    return 0.0


class _Planned(msgspec.Struct):
    seconds: float


class RestAsker:
    """Posts one body again and again over one connection."""

    def __init__(self, url: str, token: str, path: str) -> None:
        self._connection = http.client.HTTPConnection(urlsplit(url).netloc, timeout=30.0)
        self._path = path
        self._headers = {"Content-Type": "application/json", "Authorization": f"Bearer {token}"}

    def exchange(self, body: bytes) -> bytes:
        """Return the answer to a body."""
        self._connection.request("POST", self._path, body, self._headers)
        return self._connection.getresponse().read()

    def close(self) -> None:
        """Hang up."""
        self._connection.close()


async def _ask_rest(asker: RestAsker, body: bytes) -> float:
    answer = asker.exchange(body)
    began = monotonic()
    planned = msgspec.json.decode(answer, type=_Planned).seconds if answer[:1] == b"{" else 0.0
    return planned + monotonic() - began  # what reading its time takes is no time of the cloud's


@contextlib.asynccontextmanager
async def echo(kind: str, size: int) -> AsyncIterator[str]:
    """Run a server that echoes answers of a size in a process of its own; its host and port."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "robots.bench.echo_server", kind, str(size),
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
    )  # fmt: skip
    assert process.stdin is not None and process.stdout is not None
    try:
        yield f"127.0.0.1:{int(await process.stdout.readline())}"
    finally:
        process.stdin.close()
        await process.wait()
