"""Script: a minimal agent that starts one container from an image and runs until it is killed."""

import asyncio
import sys
import tempfile
from pathlib import Path

from engine.agent.entries import ENTRIES, loaded_before
from engine.processes.instances import instance_name
from engine.runtimes.base import Premises
from engine.runtimes.docker.runtime import DockerRuntime
from tests.support.engine.launches import Reports

ENTRY = "tests.support.engine.container_entries:dial_and_stay"


async def main(image: str) -> None:
    with tempfile.TemporaryDirectory(prefix="t-") as name:
        folder = Path(name)
        premises = Premises(instance_name(), folder, folder / "shm", image, ENTRIES)
        runtime = DockerRuntime(premises, loaded_before(ENTRY), spares=0)
        await runtime.start()
        async with Reports(folder) as reports:
            container = await runtime.launch(reports.launch())
            await reports.next()
            print(premises.instance, container.pid, flush=True)  # noqa: T201
            await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1]))
