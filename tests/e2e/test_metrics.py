"""A scrape of a real cloud: what it shows, and that document, alerts and dashboard name what it has."""

import asyncio
import json
import os
import re
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
import yaml
from prometheus_client.parser import text_string_to_metric_families

from endpoints.cloud_processes import server
from ppaas.maps.grid import GridMap
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.cloud.standby_process import Standby, standing_by
from tests.support.documents import table
from tests.support.sources import ROOT
from tests.support.waiting import patience
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

Samples = dict[tuple[str, frozenset[tuple[str, str]]], float]

SERIES = re.compile(r"\b(?:ppaas|process)_\w+")
"""Names of series in queries."""

WITH_TLS = {"ppaas_certificate_end_seconds"}
"""Series of a cloud that has a certificate."""


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCloud]:
    """Return a cloud that serves metrics and lists robots by name."""
    with running_cloud(tmp_path_factory.mktemp("metrics"), "--metrics", "0", "--metrics-robots") as running:
        yield running


def scrape(cloud: RunningCloud | Standby) -> Samples:
    [address] = re.findall(r"serving metrics at (\S+)", cloud.log.read_text())
    text = urllib.request.urlopen(address).read().decode()
    samples = [sample for family in text_string_to_metric_families(text) for sample in family.samples]
    found = {(sample.name, frozenset(sample.labels.items())): sample.value for sample in samples}
    assert len(found) == len(samples), "Prometheus refuses a scrape with a series twice"
    return found


def value(samples: Samples, name: str, **labels: str) -> float:
    return samples[name, frozenset(labels.items())]


async def test_a_scrape_shows_a_connected_robot_and_how_its_goal_ended(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest, start = await cloud.admin(), free_pose(office_map, seed=1)
    await publish_map(rest, "office", office_map)
    token = await register_robot(rest, "tb1", "office", start)
    async with driving(cloud.url, token, "tb1", office_map, start) as drive:
        there = scrape(cloud)
        assert value(there, "ppaas_robots", state="connected") == 1
        assert value(there, "ppaas_robot_connected", user="admin", robot="tb1") == 1
        assert value(there, "ppaas_containers", kind="robot", state="ready") == 1
        assert value(there, "ppaas_placement_seconds_count") == 1
        assert value(there, "ppaas_machine_containers", machine="local") == 1
        async with patience(30):  # endpoints report once a second
            while not value(scrape(cloud), "ppaas_requests_total", endpoint="local-1", status="2xx"):
                await asyncio.sleep(0.1)
        assert value(there, "ppaas_scrape_complete") == value(there, "ppaas_leader") == 1
        assert value(there, "ppaas_store_up", store="main") == value(there, "ppaas_store_up", store="maps") == 1
        goal = reachable_pose(office_map, start, seed=11, at_least=1.0)
        sent = await rest.post("/v1/robots/tb1/goals", {"pose": list(goal)})
        async with patience(90):
            while not value(scrape(cloud), "ppaas_goals_total", result="succeeded"):
                await asyncio.sleep(0.1)
        assert (await rest.get(f"/v1/robots/tb1/goals/{sent['id']}"))["state"] == "succeeded"
        planned = value(scrape(cloud), "ppaas_plans_total", result="computed")
        await drive.send(start, goal_id="of-a-client")
        async with patience(90):
            while value(now := scrape(cloud), "ppaas_goals_total", result="succeeded") < 2:
                await asyncio.sleep(0.1)
        computed = value(now, "ppaas_plans_total", result="computed")
        assert (
            computed == value(now, "ppaas_plan_seconds_count")
            and computed + value(now, "ppaas_plans_total", result="reused") > planned
        )
        assert value(now, "ppaas_longest_wait_seconds") == value(now, "ppaas_robots_stopped") == 0
    async with patience(30):
        while not value(scrape(cloud), "ppaas_robots", state="gone"):
            await asyncio.sleep(0.1)
    gone = scrape(cloud)
    assert value(gone, "ppaas_robots", state="connected") == 0
    assert value(gone, "ppaas_robot_connected", user="admin", robot="tb1") == 0


async def test_a_standby_answers_with_its_role_and_takes_over(tmp_path: Path) -> None:
    leader = tmp_path / "leader"
    leader.mkdir()
    stores = ("--store", f"sqlite:///{tmp_path / 'store.sqlite'}", "--map-store", f"file:///{tmp_path / 'maps'}")
    with ExitStack() as stack:
        first = stack.enter_context(running_cloud(leader, *stores, "--metrics", "0"))
        standby = stack.enter_context(standing_by(tmp_path / "standby", "--standby", *stores, "--metrics", "0"))
        await standby.stands_by()
        assert [value(scrape(one), "ppaas_leader") for one in (first, standby)] == [1, 0]
        assert value(scrape(standby), "ppaas_scrape_complete") == 0
        first.status = -signal.SIGKILL
        os.kill(first.pid, signal.SIGKILL)
        await standby.leads()
        async with patience(30):
            while not value(scrape(standby), "ppaas_scrape_complete"):
                await asyncio.sleep(0.1)
        now = scrape(standby)
        assert (value(now, "ppaas_leader"), value(now, "ppaas_epoch")) == (1, 2)


def names(samples: Samples) -> set[str]:
    return {name for name, _ in samples}


def test_the_document_lists_what_a_scrape_has(cloud: RunningCloud) -> None:
    samples = scrape(cloud)
    found: dict[str, set[str]] = {}
    for name, labels in samples:
        family = re.sub(r"(?<=_seconds)_(bucket|count|sum)$", "", name)
        found.setdefault(family, set()).update({label for label, _ in labels} - {"le"})
    described = {
        name: set(re.findall(r"\w+", labels))
        for name, labels, _ in table("docs/metrics.md", "metric", "labels", "what")
    }
    assert {name: labels for name, labels in found.items() if name.startswith("ppaas_")} == {
        name: described[name] for name in described if name in found
    }
    # Series that come with the first container or robot, or with TLS.
    optional = {"ppaas_containers", "ppaas_robot_connected", "ppaas_robot_battery_ratio", *WITH_TLS}
    assert set(described) - set(found) <= optional


def test_alerts_ask_for_series_that_a_scrape_has(cloud: RunningCloud) -> None:
    rules = yaml.safe_load((ROOT / "deploy" / "prometheus" / "ppaas.rules.yaml").read_text())
    queries = [rule["expr"] for group in rules["groups"] for rule in group["rules"]]
    assert set(SERIES.findall("\n".join(queries))) - names(scrape(cloud)) == WITH_TLS


def test_the_dashboard_asks_for_series_that_a_scrape_has(cloud: RunningCloud) -> None:
    panels = json.loads((ROOT / "deploy" / "grafana" / "ppaas.json").read_text())["panels"]
    queries = [target["expr"] for panel in panels for target in panel["targets"]]
    asked = set(SERIES.findall("\n".join(queries)))
    assert asked - names(scrape(cloud)) <= {"ppaas_containers"}  # none before the first container
    assert "ppaas_robots" in asked


def test_a_master_without_metrics_does_not_load_the_package() -> None:
    code = f"import sys, {server.__name__}; sys.exit('prometheus_client' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
