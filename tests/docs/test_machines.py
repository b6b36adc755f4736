"""Commands of machines.md work, and its settings are those of the code."""

import re
from pathlib import Path

from endpoints.rest.cluster.schemas import MachineChange
from engine.agent.host_load import AT_A_TIME, PERIOD
from engine.master.master import MOVES
from engine.processes.heartbeats import BEAT_PERIOD, MISSED
from engine.service.master_driver import LEAVE_GRACE
from engine.specs.cores import MEMORY_PER_CORE
from engine.specs.machine_settings import MOST_LABELS, MachineSettings
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import run_shell, script, table, text_of

PAGE = "docs/machines.md"


def test_the_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    printed = run_shell(script(PAGE) + "\nppaas machine label local zone=", tmp_path, cloud)
    assert '"labels": {"zone": "hall-2"}' in printed and '"max_containers": 40' in printed


def test_the_settings_are_those_of_the_code() -> None:
    rows = table(PAGE, "setting", "default", "what it is")
    assert {name for name, _, _ in rows} == set(MachineChange.model_fields) == set(MachineSettings.__struct_fields__)
    defaults = {name: default for name, default, _ in rows if default}
    assert defaults == {name: str(getattr(MachineSettings(), name)).lower() for name in defaults}


def test_the_numbers_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(PAGE))
    assert f"counts for {MEMORY_PER_CORE >> 20} MiB with each core" in text
    assert f"up to {MOST_LABELS} of" in text
    assert MOVES == 4 and "up to four at a time" in text
    assert f"has not ended after {LEAVE_GRACE:.0f} s" in text
    assert f"every {PERIOD:.0f} s each machine pings up to {AT_A_TIME} others" in text
    assert MISSED * BEAT_PERIOD == 4.0 and "for four seconds" in text
