"""retention.md: its file of settings is good, its commands work, and its table is that of the code."""

import json
import re
from pathlib import Path

import pytest

from endpoints.audit.event import MemoryAuditLog
from endpoints.audit.files import FILES, MAX_SIZE
from endpoints.cli.settings_tree import TABLES, UP
from endpoints.retention.kinds import DEFAULT_DAYS, KINDS, Kept
from endpoints.retention.service import DELAY, Retention
from endpoints.settings.effective import SettingsTree
from engine.control.tasks.group import MOST_ENDED
from tests.support.cloud.command_line import CommandLine
from tests.support.documents import blocks, script, table, text_of
from tests.unit.robots.cli.conftest import ppaas

__all__ = ["ppaas"]

PAGE = "docs/retention.md"


def test_the_file_and_the_variable_give_the_same_setting(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (text,) = blocks(PAGE, "toml")
    (tmp_path / "ppaas.toml").write_text(text)

    def setting(name: str = "retention") -> dict[str, float]:
        values, wrong = SettingsTree(TABLES, tmp_path / "ppaas.toml").values(UP)
        assert not wrong
        return dict(next(each.value for key, each in values.items() if key.name == name))

    assert setting() == {"recordings": 30.0, "audit": 365.0, "plans": 180.0}
    assert setting("retention-size") == {"recordings": 10.0}
    [variable] = re.findall(r"PPAAS_RETENTION=([\w=,]+)", text_of(PAGE))
    monkeypatch.setenv("PPAAS_RETENTION", variable)
    assert setting() == {"recordings": 30.0, "audit": 365.0}
    [variable] = re.findall(r"PPAAS_RETENTION_SIZE=([\w=,]+)", text_of(PAGE))
    monkeypatch.setenv("PPAAS_RETENTION_SIZE", variable.replace("10", "20"))
    assert setting("retention-size") == {"recordings": 20.0}


def test_the_table_is_that_of_the_code() -> None:
    rows = table(PAGE, "kind", "what is removed, and how its age is measured", "default", "other limits")
    assert [kind.strip("`") for kind, *_ in rows] == [*KINDS]
    for kind, text, default, other in rows:
        name = kind.strip("`")
        assert re.sub(r"\[(.+?)\]\(.+?\)", r"\1", text) == KINDS[name].text
        assert default == (f"{DEFAULT_DAYS[name]:g}" if name in DEFAULT_DAYS else "kept")
        if name == "audit":
            assert other == f"{FILES} files of {MAX_SIZE >> 20} MiB"
        if name == "tasks":
            assert f"last {MOST_ENDED}" in other
    assert f"{DELAY / 60:g} minute after its start" in " ".join(text_of(PAGE).split()).replace("one minute", "1 minute")


async def test_the_commands_work(ppaas: CommandLine) -> None:
    kept = Kept(ppaas.services.store, MemoryAuditLog(), None)
    object.__setattr__(ppaas.services, "retention", Retention(kept, ppaas.services.audit, {}))
    typed = [words.split()[1:] for words in script(PAGE).splitlines() if words.startswith("ppaas ")]
    assert [words[:2] for words in typed] == [
        ["retention", "show"], ["retention", "run"], ["retention", "run"], ["config", "explain"]
    ]  # fmt: skip
    for words in typed:
        ended = await ppaas(*words, user="admin")
        assert ended.status == 0, ended.err
    assert json.loads((await ppaas("config", "explain", "up.retention", "--json")).out)[0]["type"] == "table"
