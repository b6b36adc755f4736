"""The example of Alertmanager, and the monitoring of the compose file, are valid and fit the rules and each other."""

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.support.sources import ROOT

DEPLOY, MONITORING = ROOT / "deploy", ROOT / "docker" / "monitoring"
ALERTMANAGER = DEPLOY / "alertmanager" / "alertmanager.yaml"
RULES = DEPLOY / "prometheus" / "ppaas.rules.yaml"
COMPOSE = ROOT / "docker" / "compose.yaml"

needs_amtool = pytest.mark.skipif(shutil.which("amtool") is None, reason="no amtool: install prometheus-alertmanager")
needs_promtool = pytest.mark.skipif(shutil.which("promtool") is None, reason="no promtool: install prometheus")


def run(*words: str | Path) -> str:
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@needs_amtool
def test_the_example_is_valid() -> None:
    run("amtool", "check-config", ALERTMANAGER)


@needs_amtool
@pytest.mark.parametrize(("severity", "receiver"), [("critical", "pager"), ("warning", "mailbox")])
def test_an_alert_is_sent_by_its_severity(severity: str, receiver: str) -> None:
    routes = ["config", "routes", "test", f"--config.file={ALERTMANAGER}"]
    assert run("amtool", *routes, "alertname=Any", f"severity={severity}").strip() == receiver


def test_inhibitions_name_alerts_that_there_are() -> None:
    shipped = {rule["alert"] for group in yaml.safe_load(RULES.read_text())["groups"] for rule in group["rules"]}
    rules = yaml.safe_load(ALERTMANAGER.read_text())["inhibit_rules"]
    matchers = [matcher for rule in rules for matcher in rule["source_matchers"] + rule["target_matchers"]]
    named = [re.fullmatch(r'alertname=~?"([\w|]+)"', matcher) for matcher in matchers]
    assert {name for found in named if found for name in found[1].split("|")} <= shipped
    assert all(named)
    silent = [rule["target_matchers"] for rule in rules if "PPaaSNoLeader" in rule["source_matchers"][0]]
    assert any("PPaaSRobotLost" in matcher for [matcher] in silent)


@needs_promtool
def test_prometheus_of_the_compose_file_reads_its_configuration(tmp_path: Path) -> None:
    config = (MONITORING / "prometheus.yaml").read_text()
    assert "/etc/prometheus/ppaas.rules.yaml" in config
    (tmp_path / "prometheus.yaml").write_text(config.replace("/etc/prometheus/ppaas.rules.yaml", str(RULES)))
    assert "12 rules found" in run("promtool", "check", "config", tmp_path / "prometheus.yaml")


def services(profile: str) -> dict[str, Any]:
    found = yaml.safe_load(COMPOSE.read_text())["services"]
    return {name: service for name, service in found.items() if profile in service.get("profiles", ())}


def test_the_profiles_have_their_services() -> None:
    assert set(services("monitoring")) == {"prometheus", "alertmanager", "grafana"}
    assert set(services("demo")) == {"robots"}


def test_monitoring_mounts_files_that_exist_and_is_published_on_this_computer_alone() -> None:
    for service in services("monitoring").values():
        mounts = [re.sub(r"\$\{\w+:-([^}]*)\}", r"\1", mount).split(":") for mount in service["volumes"]]
        files = [source for source, *_ in mounts if source.startswith(".")]
        assert files and all((COMPOSE.parent / file).is_file() for file in files)
        assert all(port.startswith("127.0.0.1:") for port in service["ports"])


def test_the_parts_find_each_other() -> None:
    prometheus = yaml.safe_load((MONITORING / "prometheus.yaml").read_text())
    [alertmanager] = prometheus["alerting"]["alertmanagers"][0]["static_configs"][0]["targets"]
    [scraped] = prometheus["scrape_configs"][0]["dns_sd_configs"]
    [source] = yaml.safe_load((MONITORING / "datasource.yaml").read_text())["datasources"]
    assert (alertmanager, source["url"]) == ("alertmanager:9093", "http://prometheus:9090")
    everything = yaml.safe_load(COMPOSE.read_text())["services"]
    assert f"--metrics 0.0.0.0:{scraped['port']}" in everything[scraped["names"][0]]["command"]
    [variable] = json.loads((DEPLOY / "grafana" / "ppaas.json").read_text())["templating"]["list"]
    assert variable["query"] == source["type"]


def test_the_image_has_what_the_commands_need() -> None:
    image = (ROOT / "docker" / "engine.Dockerfile").read_text()
    assert {"cloud", "metrics", "backup"} <= set(re.findall(r"--extra (\w+)", image))
