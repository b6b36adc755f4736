"""Script that serves ``count`` on the fabric and records the executed requests in order.

``python -m tests.support.engine.fabric_server``, with ``Settings`` as JSON on standard input; ends with it.
"""

import asyncio
import sys

import msgspec

from engine.fabric.session import Fabric
from engine.fabric.zenoh_config import RouterCredentials


class Settings(msgspec.Struct):
    endpoint: str
    credentials: RouterCredentials


async def run(settings: Settings) -> None:
    executed: list[str] = []

    async def count(key: str, payload: bytes) -> bytes:
        executed.append(payload.decode())
        await asyncio.sleep(
            0.002 * (len(executed) % 10)
        )  # so that some requests are executing whenever the router dies
        return payload[::-1]

    async def tell(key: str, payload: bytes) -> bytes:
        return msgspec.json.encode(executed)

    fabric = await Fabric.open(settings.endpoint, settings.credentials)
    fabric.serve("count", count)
    fabric.serve("tell", tell)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    await asyncio.to_thread(sys.stdin.read)
    await fabric.close()


if __name__ == "__main__":
    asyncio.run(run(msgspec.json.decode(sys.stdin.buffer.readline(), type=Settings)))
