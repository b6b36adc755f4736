import asyncio
import json

import pytest

from engine.specs.machine_settings import MachineSettings
from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.fake_cloud import endpoint
from tests.support.waiting import until


async def test_an_administrator_lists_the_machines(ppaas: CommandLine) -> None:
    ended = await ppaas("machine", "list", user="admin")
    assert ended.rows == [
        [
            "id",
            "state",
            "cores",
            "capacity",
            "given",
            "containers",
            "load",
            "memory_used",
            "memory",
            "labels",
            "kernels",
            "release",
        ],
        ["m1", "ready", "4", "16", "1", "1", "0.5", "1.0", "GiB", "8.0", "GiB", "-", "-", "0.2.0"],
    ]


@pytest.mark.parametrize(
    "verb", ["list", "endpoints", "show m1", "drain m1", "label m1 a=b", "limit m1 --max-containers 1"]
)
async def test_machine_commands_require_an_administrator(ppaas: CommandLine, verb: str) -> None:
    ended = await ppaas("machine", *verb.split())
    assert (ended.status, ended.out) == (1, "")
    assert ended.err == "ppaas: not-permitted: only an administrator may do this\n"
    assert ppaas.cloud.known["m1"].settings == MachineSettings()


async def test_a_machine_is_shown_by_its_id(ppaas: CommandLine) -> None:
    shown = await ppaas("machine", "show", "m1", user="admin")
    listed = await ppaas("machine", "list", user="admin")
    assert shown.rows[0] == [*listed.rows[0], "network_used", "network", "round_trip"]
    assert shown.rows[1] == [*listed.rows[1], "2.0", "MiB/s", "-", "1.5", "ms"]
    assert (
        await ppaas("machine", "show", "m2", user="admin")
    ).err == "ppaas: not-found: unknown machine 'm2'; known: m1\n"


async def test_an_administrator_lists_the_endpoints(ppaas: CommandLine) -> None:
    ppaas.cloud.serving = [endpoint("local-2", sockets=0, state="silent"), endpoint("local-1")]
    ended = await ppaas("machine", "endpoints", user="admin")
    assert ended.rows == [
        ["id", "machine", "state", "sockets", "frames", "cpu", "memory", "release", "pid", "url"],
        ["local-1", "m1", "ready", "3", "60", "25", "%", "90.0", "MiB", "0.2.0", "4711", "http://127.0.0.1:8500"],
        ["local-2", "m1", "silent", "0", "60", "25", "%", "90.0", "MiB", "0.2.0", "4711", "http://127.0.0.1:8500"],
    ]
    listed = json.loads((await ppaas("machine", "endpoints", "--json", "--limit", "1", user="admin")).out)
    assert [(one["id"], one["memory"]) for one in listed] == [("local-1", 90 << 20)]
    ppaas.cloud.serving.clear()
    assert "no endpoints are connected" in (await ppaas("machine", "endpoints", user="admin")).out


async def test_a_machine_is_drained_and_undrained(ppaas: CommandLine) -> None:
    drained = await ppaas("machine", "drain", "m1", user="admin")
    assert drained.rows[1][:2] == ["m1", "draining"]
    undrained = await ppaas("machine", "undrain", "m1", user="admin")
    assert undrained.rows[1][:2] == ["m1", "ready"]


async def test_drain_with_wait_returns_when_the_machine_is_drained(ppaas: CommandLine) -> None:
    waiting = asyncio.create_task(ppaas("machine", "drain", "m1", "--wait", user="admin"))
    await until(lambda: ppaas.cloud.known["m1"].settings.draining)
    ppaas.cloud.known["m1"].containers.clear()
    assert (await waiting).rows[1][:2] == ["m1", "drained"]


async def test_labels_are_set_and_removed(ppaas: CommandLine) -> None:
    labelled = await ppaas("machine", "label", "m1", "zone=a", "gpu=yes", user="admin")
    assert labelled.rows[1][-2:] == ["gpu=yes,", "zone=a"]
    assert (await ppaas("machine", "label", "m1", "gpu=", user="admin")).rows[1][-1] == "zone=a"
    ended = await ppaas("machine", "label", "m1", "zone", user="admin")
    assert ended.status == 2 and "must be KEY=VALUE, not 'zone'" in ended.err


async def test_limits_are_set_and_reset_to_the_default(ppaas: CommandLine) -> None:
    limits = ("--max-containers", "7", "--max-memory", "4G", "--oversubscription", "1.5")
    limited = await ppaas("machine", "limit", "m1", *limits, user="admin")
    assert limited.rows == [
        ["id", "state", "max_containers", "oversubscription", "max_memory", "labels"],
        ["m1", "ready", "7", "1.5", "4.0", "GiB", "-"],
    ]
    assert ppaas.cloud.known["m1"].settings == MachineSettings({}, 7, 1.5, 4 << 30)
    await ppaas("machine", "limit", "m1", "--max-memory", "default", "--max-containers", "default", user="admin")
    assert ppaas.cloud.known["m1"].settings == MachineSettings(oversubscription=1.5)


@pytest.mark.parametrize("given", ["", "--max-containers many", "--max-memory 4X", "--oversubscription 0"])
async def test_an_invalid_limit_changes_nothing(ppaas: CommandLine, given: str) -> None:
    ended = await ppaas("machine", "limit", "m1", *given.split(), user="admin")
    assert ended.status != 0 and ended.out == ""
    assert ppaas.cloud.known["m1"].settings == MachineSettings()


async def test_a_machine_is_removed_and_admitted(ppaas: CommandLine) -> None:
    kept = await ppaas("machine", "remove", "m1", user="admin")
    assert kept.status == 1 and "drain it first" in kept.err
    assert (await ppaas("machine", "remove", "m1", "--force", user="admin")).status == 0
    assert "no machine" in (await ppaas("machine", "list", user="admin")).out
    assert (await ppaas("machine", "admit", "m1", user="admin")).rows[1] == ["m1"]
    assert (await ppaas("machine", "list", "--json", user="admin")).out.startswith('[{"id": "m1"')
