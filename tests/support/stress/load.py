"""Load on a cloud, for some seconds: ``python -m tests.support.stress.load URL TOKEN ROBOT SECONDS``.

It logs in again and again, fetches the map of the robot over three sockets at a time, and reads a fourth hardly at all.
"""

import asyncio
import json
import sys

from websockets.asyncio.client import connect

from robots.client.rest import RestClient
from tests.support.cloud.cloud import ADMIN_PASSWORD

SUBSCRIBERS = 3
LOGINS = 4


async def main(url: str, token: str, robot: str, seconds: float) -> dict[str, int]:
    """Return how much was done."""
    socket = f"{url.replace('http', 'ws', 1)}/?robot={robot}&token={token}&role=operator"
    done = {"logins": 0, "maps": 0}
    loop = asyncio.get_running_loop()
    end = loop.time() + seconds
    async with connect(socket, max_size=None, max_queue=1) as slow:
        for topic in ("map", "tf", "particlecloud", "move_base/status"):
            await slow.send(json.dumps({"op": "subscribe", "topic": topic}))
        while loop.time() < end:
            logins = [RestClient(url).login("admin", ADMIN_PASSWORD) for _ in range(LOGINS)]
            await asyncio.gather(*logins, *(fetch_map(socket) for _ in range(SUBSCRIBERS)))
            done["logins"] += LOGINS
            done["maps"] += SUBSCRIBERS
    return done


async def fetch_map(url: str) -> None:
    """Subscribe to the map and wait for it."""
    async with connect(url, max_size=None) as socket:
        await socket.send(json.dumps({"op": "subscribe", "topic": "/map"}))
        frame = await socket.recv()
        assert len(frame) > 1_700_000


if __name__ == "__main__":
    url, token, robot, seconds = sys.argv[1:]
    sys.stdout.write(json.dumps(asyncio.run(main(url, token, robot, float(seconds)))))
