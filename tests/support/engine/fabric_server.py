"""Run as a script: serves ``count`` on the fabric and remembers, in order, what it carried out.

``python -m tests.support.engine.fabric_server``, settings as JSON on standard input; ends with it.
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
    carried_out: list[str] = []

    async def count(key: str, payload: bytes) -> bytes:
        carried_out.append(payload.decode())
        await asyncio.sleep(0.002 * (len(carried_out) % 10))  # some are under way whenever the router dies
        return payload[::-1]

    async def tell(key: str, payload: bytes) -> bytes:
        return msgspec.json.encode(carried_out)

    fabric = await Fabric.open(settings.endpoint, settings.credentials)
    fabric.serve("count", count)
    fabric.serve("tell", tell)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    await asyncio.to_thread(sys.stdin.read)
    await fabric.close()


if __name__ == "__main__":
    asyncio.run(run(msgspec.json.decode(sys.stdin.buffer.readline(), type=Settings)))
