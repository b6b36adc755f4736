"""The process of a container from start to end, with a fake endpoint and a fake machine."""

import asyncio
import re
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from engine.agent import store_requests
from engine.container.entry import run
from engine.protocols import machine_link, robot_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import ContainerSpec, Launch
from engine.specs.layer_files import write_layers
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.people.settings import PeopleSettings
from ppaas.plans.encoding import kernels
from storage import plan_entry, ports
from tests.support.engine.specs import HOUSE, coordinator_spec, planning_spec, robot_config, traffic_spec
from tests.support.waiting import patience


def test_container_does_not_import_store_modules() -> None:
    """Otherwise all containers of a machine would have those modules in their memory."""
    code = "import sys, engine.container.entry; print(*(name for name in sys.modules if name in sys.argv[1:]))"
    names = [module.__name__ for module in (ports, plan_entry, kernels, sqlite3, store_requests)]
    loaded = subprocess.run([sys.executable, "-c", code, *names], check=True, capture_output=True, text=True).stdout
    assert loaded.split() == []


@pytest.fixture
def layers(tmp_path: Path) -> Path:
    info = GridInfo(0.05, 20, 20, Pose2D(0.0, 0.0, 0.0))
    grid = GridMap(np.zeros((20, 20), np.int8), info)
    costmap = Costmap(np.zeros((20, 20), np.uint8), info)
    folder = tmp_path / "layers"
    folder.mkdir()
    write_layers(folder, MapLayers(grid, costmap, np.full((20, 20), 1.0, np.float32)), created=0.0)
    return folder


async def first_frame(spec: ContainerSpec, layers: Path, tmp_path: Path) -> robot_link.FromContainer | None:
    """Run a container until its first frame, then send a shutdown; return the frame."""
    frames: asyncio.Queue[robot_link.FromContainer | None] = asyncio.Queue()

    async def endpoint(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        stream: FrameStream[robot_link.FromContainer] = FrameStream(reader, writer, robot_link.FromContainer)
        frames.put_nowait(await stream.receive())
        await stream.send(robot_link.Shutdown())
        await stream.close()

    async def machine(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        stream: FrameStream[machine_link.FromContainer] = FrameStream(reader, writer, machine_link.FromContainer)
        while isinstance(frame := await stream.receive(), machine_link.AttachContainer | machine_link.SaveClone):
            if isinstance(frame, machine_link.SaveClone):
                stream.write(machine_link.Done(frame.request))
        await stream.close()

    paths = str(tmp_path / "link.sock"), str(tmp_path / "gate.sock")
    servers = [
        await asyncio.start_unix_server(serve, path) for serve, path in zip((endpoint, machine), paths, strict=True)
    ]
    async with patience(60):
        await run(Launch(spec, str(layers), *paths, secret="secret", cpus=(0,), threads=1))
    for server in servers:
        server.close()
    return await frames.get()


async def test_container_sends_hello_and_ends_on_shutdown(layers: Path, tmp_path: Path) -> None:
    hello = await first_frame(planning_spec("p1"), layers, tmp_path)
    assert isinstance(hello, robot_link.Hello)
    assert (hello.container, hello.secret) == ("p1", "secret")
    assert robot_link.ServiceInfo("compute_path", "ppaas_msgs/ComputePath") in hello.services
    assert "map" in {topic.name for topic in hello.topics}


async def test_a_coordinator_serves_people_and_begins_anew_without_a_checkpoint_it_can_read(
    layers: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    spec = replace(coordinator_spec("k1"), checkpoint={"people_coordinator": b"of another release"})
    hello = await first_frame(spec, layers, tmp_path)
    assert isinstance(hello, robot_link.Hello)
    assert [node.name for node in hello.nodes] == ["people_coordinator"]
    assert robot_link.ServiceInfo("people_coordinator/get_people", "ppaas_msgs/GetPeople") in hello.services
    assert "begins anew" in caplog.text


async def test_a_traffic_node_serves_traffic(layers: Path, tmp_path: Path) -> None:
    hello = await first_frame(traffic_spec("t1"), layers, tmp_path)
    assert isinstance(hello, robot_link.Hello)
    assert [node.name for node in hello.nodes] == ["traffic"]
    assert robot_link.ServiceInfo("traffic/get_traffic", "ppaas_msgs/GetTraffic") in hello.services


async def test_a_coordinator_with_an_unknown_rule_reports_why(layers: Path, tmp_path: Path) -> None:
    spec = replace(coordinator_spec("k1"), people=PeopleSettings(rule="guess"))
    failed = await first_frame(spec, layers, tmp_path)
    assert isinstance(failed, robot_link.ContainerFailed)
    assert failed.refusal.slug == "not-found" and "nearest" in failed.refusal.text


@pytest.mark.parametrize(
    ("fields", "slug", "text"),
    [
        ({"model": "toaster"}, "not-found", "known: .*turtlebot2"),
        ({"base_global_planner": "guess"}, "not-found|invalid-planner", "dijkstra"),
        ({"parameters": {"move_base": {"controller_frequency": "often"}}}, "invalid-parameter", "controller_frequency"),
    ],
    ids=["model", "planner", "parameter"],
)
async def test_container_with_an_invalid_config_reports_why_and_ends(
    layers: Path, tmp_path: Path, fields: dict[str, Any], slug: str, text: str
) -> None:
    spec = ContainerSpec("c1", "ann", HOUSE, 1.0, robot_config(**fields))
    failed = await first_frame(spec, layers, tmp_path)
    assert isinstance(failed, robot_link.ContainerFailed)
    assert (failed.container, failed.secret) == ("c1", "secret")
    assert re.fullmatch(slug, failed.refusal.slug)
    assert re.search(text, failed.refusal.text)


async def test_unreadable_checkpoint_is_refused_with_its_nodes_name(layers: Path, tmp_path: Path) -> None:
    spec = ContainerSpec("c1", "ann", HOUSE, 1.0, robot_config(), checkpoint={"move_base": b'{"goal": "elsewhere"}'})
    failed = await first_frame(spec, layers, tmp_path)
    assert isinstance(failed, robot_link.ContainerFailed)
    assert failed.refusal.slug == "invalid-input"
    assert "the checkpoint of node 'move_base' cannot be read" in failed.refusal.text
    assert "connect again" in failed.refusal.text


async def test_container_without_layers_reports_unavailable(tmp_path: Path) -> None:
    failed = await first_frame(planning_spec(), tmp_path / "gone", tmp_path)
    assert isinstance(failed, robot_link.ContainerFailed)
    assert failed.refusal.slug == "unavailable"
