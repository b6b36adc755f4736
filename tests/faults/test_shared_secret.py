"""Two masters that the same command starts begin a cloud; a machine joins with a secret, and follows the other one."""

import os
import signal
from pathlib import Path

import pytest

from benchmarks.harness.free_ports import free_ports
from tests.support.cloud.joined_machine import JoinedMachine
from tests.support.cloud.standby_process import standing_by
from tests.support.engine.processes import has_ended
from tests.support.waiting import until

pytestmark = pytest.mark.journey


async def test_masters_and_machines_with_secrets_need_no_ticket(tmp_path: Path) -> None:
    ports, join, standbys = free_ports(4), tmp_path / "join", tmp_path / "standbys"
    join.write_text("j" * 32)
    standbys.write_text("s" * 32)
    masters = ("--master", f"127.0.0.1:{ports[0]}", "--master", f"127.0.0.1:{ports[2]}")
    stores = ("--store", f"sqlite:///{tmp_path / 'store.sqlite'}", "--map-store", f"file:///{tmp_path / 'maps'}")
    secrets = ("--join-secret-file", str(join), "--standby-secret-file", str(standbys))
    common = ("--standby", *secrets, *masters, *stores, "--cores", "1", "--adopt-within", "12")
    machine = JoinedMachine(tmp_path / "m2", "m2")
    machine.start("--join-secret-file", str(join), *masters)
    with standing_by(tmp_path / "first", *common, "--listen-machines", f"127.0.0.1:{ports[0]}") as first:
        leader = await first.leads()
        await machine.is_in(await leader.admin())
        agent = leader.agent()
        with standing_by(tmp_path / "second", *common, "--listen-machines", f"127.0.0.1:{ports[2]}") as second:
            await second.stands_by()
            os.kill(leader.pid, signal.SIGKILL)
            first.process.wait(20.0)
            heir = await second.leads()
            await machine.is_in(await heir.admin())
            await until(lambda: has_ended(agent.pid), 40.0)
            machine.end()
