"""Joint: kernels in forked containers, on threads, beside Zenoh."""

import asyncio
import os

import msgspec
import pytest

from engine.agent.entries import loaded_before
from engine.agent.layer_builder import LayerBuilder
from engine.agent.map_cache import MapCache
from engine.fabric.router import RouterProcess
from engine.fabric.session import Fabric
from engine.runtimes.process.runtime import ProcessRuntime
from engine.specs.containers import LayerSpec
from tests.support.engine.launches import Reports
from tests.support.storage.records import YAML, house, kept
from tests.support.stress.containers import Strain

pytestmark = pytest.mark.joint

CPUS = tuple(sorted(os.sched_getaffinity(0)))


@pytest.fixture
async def reports(tmp_path):
    async with Reports(tmp_path) as server:
        yield server


@pytest.fixture
async def router(tmp_path):
    process = RouterProcess(tmp_path / "run")
    await process.start()
    yield process
    await process.close()


@pytest.mark.parametrize("zenoh_in", ["agent", "container"])
@pytest.mark.parametrize("cores", [1, 2])
async def test_parallel_kernels_in_containers_neither_abort_nor_err(cores, zenoh_in, seconds, reports, router, figure):
    if len(CPUS) < cores:
        pytest.skip(f"the machine has no {cores} CPUs")
    runtime = ProcessRuntime(loaded_before("tests.support.stress.containers:strain_kernels"))
    await runtime.start()
    fabric = await Fabric.open(router.endpoint, router.credentials)
    strain = Strain(seconds)
    if zenoh_in == "container":
        strain = Strain(seconds, router.endpoint, router.credentials)
    secret = msgspec.json.encode(strain).decode()
    container = await runtime.launch(reports.launch(cpus=CPUS[:cores], threads=cores, secret=secret))
    ending = asyncio.create_task(container.wait())
    while not ending.done():
        fabric.publish("ppaas/ann/home/tb1/scan", bytes(1000))
        await asyncio.wait([ending], timeout=0.01)
    assert ending.result() == 0
    forked_warm, layer, least, calls, wrong = (await reports.next()).text.split(" ", 4)
    assert forked_warm == "True"
    assert layer in ("tbb", "serial")
    assert wrong == "[]"
    assert int(least) > 0
    figure("kernel calls a second", int(calls) / seconds)
    await runtime.close()
    await fabric.close()


@pytest.mark.parametrize("threads", [1, 2])
async def test_a_container_plans_on_shared_layers_without_compiling(threads, tmp_path, reports, figure):
    runtime = ProcessRuntime(loaded_before("tests.support.stress.containers:plan_once"))
    await runtime.start()
    cells = bytearray([254]) * (220 * 220)
    given = house(yaml=YAML.replace(b"-1.0, -2.0", b"0.0, 0.0"), image=b"P5\n220 220\n255\n" + bytes(cells))
    cache = MapCache(tmp_path / "shm", build=LayerBuilder(kept(given)))
    layers = await cache.ensure(LayerSpec(given, 0.18))
    container = await runtime.launch(reports.launch(cpus=CPUS, threads=threads, layers=str(layers)))
    assert await container.wait() == 0
    milliseconds, length, compiled = (await reports.next()).text.split(" ", 2)
    assert compiled == "[]"
    assert float(length) == pytest.approx(12.7, abs=0.2)
    figure("first plan in a new container, ms", float(milliseconds))
    await runtime.close()
