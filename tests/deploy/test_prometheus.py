"""The alerts of Prometheus fire when they should, by promtool."""

import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

from tests.support.sources import ROOT

RULES = ROOT / "deploy" / "prometheus" / "ppaas.rules.yaml"
TESTS = sorted((ROOT / "deploy" / "prometheus" / "tests").glob("*.yaml"))

needs_promtool = pytest.mark.skipif(shutil.which("promtool") is None, reason="no promtool: install prometheus")


def promtool(*words: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["promtool", *words], capture_output=True, text=True, check=False)


@needs_promtool
def test_the_rules_are_valid() -> None:
    done = promtool("check", "rules", RULES)
    assert done.returncode == 0, done.stdout + done.stderr


@needs_promtool
@pytest.mark.parametrize("file", TESTS, ids=lambda file: file.stem)
def test_alerts_fire_for_their_values_alone(file: Path) -> None:
    done = promtool("test", "rules", file)
    assert done.returncode == 0, done.stdout + done.stderr


@needs_promtool
def test_a_rule_that_never_fires_fails(tmp_path: Path) -> None:
    (tmp_path / "tests").mkdir()
    (tmp_path / RULES.name).write_text(RULES.read_text().replace('{state="gone"} > 0', '{state="gone"} > 9'))
    for file in TESTS:
        shutil.copy(file, tmp_path / "tests")
    done = promtool("test", "rules", *(tmp_path / "tests").iterdir())
    assert done.returncode != 0 and "PPaaSRobotLost" in done.stdout + done.stderr


def test_each_alert_is_seen_firing_and_not_firing() -> None:
    shipped = {rule["alert"] for group in yaml.safe_load(RULES.read_text())["groups"] for rule in group["rules"]}
    seen = [
        (alert["alertname"], bool(alert["exp_alerts"]))
        for file in TESTS
        for test in yaml.safe_load(file.read_text())["tests"]
        for alert in test["alert_rule_test"]
    ]
    assert set(seen) == {(alert, fires) for alert in shipped for fires in (True, False)}
