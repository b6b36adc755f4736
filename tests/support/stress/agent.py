"""Run as a script: a small agent, with a fork server, a router, shared maps and containers, to be killed.

``python -m tests.support.stress.agent FOLDER``: writes one line of JSON with what it started.
"""

import asyncio
import json
import sys
from pathlib import Path

from engine.agent.entries import loaded_before
from engine.agent.layer_builder import LayerBuilder
from engine.agent.map_cache import MapCache
from engine.fabric.router import RouterProcess
from engine.fabric.session import Fabric
from engine.processes.instances import folder_of, instance_name
from engine.runtimes.process.runtime import ProcessRuntime
from engine.specs.containers import LayerSpec
from tests.support.engine.launches import Reports
from tests.support.storage.records import house, kept, pgm


async def run(folder: Path) -> None:
    runtimes = [
        ProcessRuntime(loaded_before(f"tests.support.engine.container_entries:{name}"))
        for name in ("dial_and_stay", "hold_the_interpreter")
    ]
    for runtime in runtimes:
        await runtime.start()
    router = RouterProcess(folder / "run")
    await router.start()
    fabric = await Fabric.open(router.endpoint, router.credentials)
    fabric.subscribe("ppaas/**", lambda key, payload: None)
    shared = folder_of(instance_name())
    given = house(image=pgm(20, 20))
    await MapCache(shared, build=LayerBuilder(kept(given))).ensure(LayerSpec(given, 0.18))
    async with Reports(folder) as reports:
        containers = []
        for runtime in (*runtimes, runtimes[0], runtimes[0], runtimes[0]):
            containers.append(await runtime.launch(reports.launch()))
            await reports.next()
        pids = [container.pid for container in containers]
        started = {"containers": pids, "router": router.pid, "shared": str(shared)}
        sys.stdout.write(json.dumps(started) + "\n")
        sys.stdout.flush()
        await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(run(Path(sys.argv[1])))
