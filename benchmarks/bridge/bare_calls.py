"""Program: a client of the REST service that asks for one goal again and again, and prints what it took.

``python -m benchmarks.bridge.bare_calls URL PATH COUNT`` prints the seconds and the CPU time of a call.
"""

import asyncio
import sys
from time import process_time

from ppaas.clock import monotonic
from robots.client.rest import RestClient


async def _run(url: str, path: str, count: int) -> tuple[float, float]:
    rest = RestClient(url, "t")
    await rest.get(path)
    began, used = monotonic(), process_time()
    for _ in range(count):
        await rest.get(path)
    return (monotonic() - began) / count, (process_time() - used) / count


if __name__ == "__main__":
    taken, used = asyncio.run(_run(sys.argv[1], sys.argv[2], int(sys.argv[3])))
    sys.stdout.write(f"{taken} {used}\n")
