"""The rules of the bench are shorter ones of ours, and its receiver notes when each alert fires and resolves."""

import asyncio
import json
import re
import shutil
import subprocess
import urllib.request
from pathlib import Path

import pytest
import yaml

from benchmarks.alerts.monitoring import RULES, Notifications, hurried, receiver
from benchmarks.harness.free_ports import free_ports
from ppaas.clock import monotonic


def test_patience_and_windows_are_shorter_and_nothing_else() -> None:
    rules = "expr: increase(a_total[10m]) > 0.5 and b < 14 * 86400\nfor: 30s\ndescription: waited for 10 minutes"
    assert hurried(rules, 60.0) == (
        "expr: increase(a_total[10000ms]) > 0.5 and b < 14 * 86400\nfor: 500ms\ndescription: waited for 10 minutes"
    )


def test_the_rules_in_no_hurry_take_as_long() -> None:
    shipped, same = RULES.read_text(), hurried(RULES.read_text(), 1.0)
    assert len(re.findall(r"\dms\b", same)) == len(re.findall(r"for: \d|\[\d+[smh]\]", shipped))
    assert yaml.safe_load(same)["groups"][0]["rules"][0]["for"] == "30000ms"


@pytest.mark.skipif(shutil.which("promtool") is None, reason="no promtool: install prometheus")
def test_hurried_rules_are_valid(tmp_path: Path) -> None:
    (tmp_path / "rules.yaml").write_text(hurried(RULES.read_text(), 30.0))
    done = subprocess.run(["promtool", "check", "rules", tmp_path / "rules.yaml"], capture_output=True, check=False)
    assert done.returncode == 0, done.stdout


def post(port: int, **alerts: str) -> None:
    body = {"alerts": [{"labels": {"alertname": name}, "status": status} for name, status in alerts.items()]}
    urllib.request.urlopen(f"http://127.0.0.1:{port}/", json.dumps(body).encode()).close()


async def test_an_alert_is_seen_only_after_it_was_waited_for() -> None:
    heard, [port] = Notifications(), free_ports(1)
    with receiver(port, heard):
        await asyncio.to_thread(post, port, A="firing", B="firing")
        first = await heard.when("A", "firing", 0.0, 10.0)
        assert first is not None
        assert await heard.when("A", "resolved", 0.0, 0.01) is None
        assert await heard.when("A", "firing", first, 0.01) is None
        waiting = asyncio.create_task(heard.when("A", "resolved", monotonic(), 10.0))
        await asyncio.to_thread(post, port, A="resolved")
        resolved = await waiting
        assert resolved is not None and resolved > first
