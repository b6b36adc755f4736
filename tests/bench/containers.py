"""How fast a robot has its container, and how much memory it takes: ``make bench``.

Ready is measured from the opening of an authenticated WebSocket to the first message of its clone, one that is latched,
over a real cloud whose map is in shared memory already. Memory is the proportional set size after a minute of driving,
which counts a page that is shared by n processes as 1/n; the shared map is told apart.
"""

import argparse
import asyncio
import json
import statistics
import sys
import tempfile
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import track
from rich.table import Table
from websockets.asyncio.client import connect

from ppaas.clock import monotonic
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap
from robots.rest import RestClient
from tests.support.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.drive import Drive, driving
from tests.support.places import free_pose, reachable_pose

MAP = "warehouse"
ROBOTS = 3
console = Console(stderr=True)


def main() -> int:
    """Measure, and print a table or JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--opens", type=int, default=20, help="robots whose container is timed (%(default)s)")
    parser.add_argument("--seconds", type=float, default=60.0, help="of driving before memory is read (%(default)s)")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, running_cloud(Path(folder), "--linger", "0.1") as cloud:
        figures = asyncio.run(measure(cloud, arguments.opens, arguments.seconds))
    if arguments.json:
        sys.stdout.write(json.dumps(figures) + "\n")
    else:
        Console().print(table(figures))
    return 0


async def measure(cloud: RunningCloud, opens: int, seconds: float) -> dict[str, Any]:
    """Return the figures of one cloud."""
    grid = warehouse(seed=1)
    rest = await cloud.admin()
    await publish_map(rest, MAP, grid)
    ready = [await time_open(cloud, rest, grid, n) for n in track(range(opens + 1), "opening", console=console)][1:]
    return {
        "opens": opens,
        "ready_ms": {"median": _ms(statistics.median(ready)), "min": _ms(min(ready)), "max": _ms(max(ready))},
        "driving_seconds": seconds,
        "containers": await drive_and_weigh(cloud, rest, grid, seconds),
    }


async def time_open(cloud: RunningCloud, rest: RestClient, grid: GridMap, number: int) -> float:
    """Return the seconds from opening a robot's socket to the first message of its clone."""
    token = await register_robot(rest, f"open{number}", MAP, free_pose(grid, seed=1))
    url = f"{cloud.ws_url}/?robot=open{number}&token={token}"
    began = monotonic()
    async with connect(url, max_size=None) as socket:
        await socket.send('{"op":"subscribe","topic":"tf_static"}')
        await socket.recv()
        return monotonic() - began


async def drive_and_weigh(cloud: RunningCloud, rest: RestClient, grid: GridMap, seconds: float) -> list[dict[str, Any]]:
    """Let robots drive to and fro; return what their containers use at the end."""
    async with AsyncExitStack() as stack:
        roaming = []
        for number in range(ROBOTS):
            start = free_pose(grid, seed=80 + number)
            token = await register_robot(rest, f"r{number}", MAP, start)
            drive = await stack.enter_async_context(driving(cloud.url, token, f"r{number}", grid, start))
            roaming.append(asyncio.create_task(roam(drive, grid)))
        for _ in track(range(max(round(seconds), 1)), "driving", console=console):
            await asyncio.sleep(1.0)
        listed = await rest.get("/v1/containers")
        for task in roaming:
            task.cancel()
    mine = [c for c in listed if c["robot"] in {f"r{n}" for n in range(ROBOTS)}]
    return [{"robot": c["robot"], "pss_mb": round(c["pss"] / 1e6, 1), **private(c["pid"])} for c in mine]


def private(pid: int) -> dict[str, float]:
    """Return what of a process' memory is its own, and what of the map it shares [MB]."""
    own = shared_map = 0.0
    mapped = False
    for line in Path(f"/proc/{pid}/smaps").read_text().splitlines():
        field, _, rest = line.partition(" ")
        if not field.endswith(":"):
            mapped = "/dev/shm/ppaas-" in line
        elif field == "Pss:" and mapped:
            shared_map += int(rest.split()[0]) / 1e3
        elif field in ("Private_Clean:", "Private_Dirty:") and not mapped:
            own += int(rest.split()[0]) / 1e3
    return {"private_mb": round(own, 1), "map_pss_mb": round(shared_map, 1)}


async def roam(drive: Drive, grid: GridMap) -> None:
    """Drive from place to place."""
    start = drive.world.robots[0].base.pose
    for seed in range(1000):
        await drive.go(reachable_pose(grid, start, seed=seed, at_least=4.0), timeout=120.0)


def _ms(seconds: float) -> float:
    return round(1e3 * seconds, 1)


def table(figures: dict[str, Any]) -> Table:
    """Return the figures for people."""
    shown = Table(title="containers", show_header=False)
    ready = figures["ready_ms"]
    shown.add_row(f"ready, median of {figures['opens']}", f"{ready['median']} ms ({ready['min']}–{ready['max']})")
    for container in figures["containers"]:
        name = f"{container['robot']} after {figures['driving_seconds']:g} s"
        map_mb, own = container["map_pss_mb"], container["private_mb"]
        sizes = f"PSS {container['pss_mb']} MB, of it the map {map_mb}; private {own}"
        shown.add_row(name, sizes)
    return shown


if __name__ == "__main__":
    sys.exit(main())
