"""Script that subscribes to ``feed/**``, sleeps after each message, and writes a line for it.

``python -m tests.support.engine.fabric_reader SECONDS``, with ``Settings`` as JSON on standard input; ends with it.
"""

import asyncio
import sys
import time

import msgspec

from engine.fabric.session import Fabric
from tests.support.engine.fabric_server import Settings


async def run(settings: Settings, pause: float) -> None:
    def take(key: str, payload: bytes) -> None:
        sys.stdout.write(f"{int.from_bytes(payload[:8], 'big')}\n")
        sys.stdout.flush()
        time.sleep(pause)

    fabric = await Fabric.open(settings.endpoint, settings.credentials)
    fabric.subscribe("feed/**", take)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    await asyncio.to_thread(sys.stdin.read)
    await fabric.close()


if __name__ == "__main__":
    asyncio.run(run(msgspec.json.decode(sys.stdin.buffer.readline(), type=Settings), float(sys.argv[1])))
