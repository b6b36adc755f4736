"""What a scrape has of a snapshot: robots, webhooks, plans, and the certificate."""

import asyncio
from collections import Counter
from dataclasses import replace

import pytest
from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.parser import text_string_to_metric_families

from endpoints.metrics.collector import CloudCollector
from endpoints.metrics.families import LONGEST_LABEL, MOST_SERIES
from endpoints.metrics.robot_watch import RobotSeen
from endpoints.metrics.snapshot import Snapshot
from endpoints.resources.store_health import StoreState
from endpoints.webhooks.service import WebhookNumbers
from engine.control.counts import ControlCounts
from engine.specs.robot_report import StateReport
from engine.specs.work_counts import CLASSES, FAILED, PLAN_MICROS
from ppaas.messages.actionlib_msgs import Status

Values = dict[tuple[str, ...], float]

NOTHING = Snapshot(
    store=StoreState(answers=True), map_store=StoreState(answers=True), audit=True, disk=None, machines=[],
    containers=[], endpoints=[], people=[], robots=[], longest_wait=0.0, requests={}, queued=0, gone=0, tasks=Counter(),
    counts=ControlCounts(), webhooks=WebhookNumbers(Counter(), {}, {}, 0), certificate_ends=None,
)  # fmt: skip


class Fixed:
    """A master whose state does not change."""

    def __init__(self, found: Snapshot) -> None:
        self.found = found

    async def read(self) -> Snapshot:
        return self.found


async def scrape(found: Snapshot, *, robots: bool = False) -> Values:
    """Return the values of a scrape by the names of the series and the values of their labels."""
    collector, registry = CloudCollector(asyncio.get_running_loop(), robots=robots), CollectorRegistry()
    collector.source = Fixed(found)
    registry.register(collector)
    text = (await asyncio.to_thread(generate_latest, registry)).decode()
    samples = [sample for family in text_string_to_metric_families(text) for sample in family.samples]
    values = {(sample.name, *sample.labels.values()): sample.value for sample in samples}
    assert len(values) == len(samples), "Prometheus refuses a scrape with a series twice"
    return values


def robot(name: str, *, connected: bool = True, stopped: bool = False, **report: object) -> RobotSeen:
    given = StateReport(**report)  # type: ignore[arg-type]
    return RobotSeen("ann", name, connected=connected, stopped=stopped, report=given)


async def test_robots_are_counted_by_what_holds_them_up() -> None:
    waits = {"goal": Status.ACTIVE, "goal_text": "waiting: tb2 goes first"}
    robots = [
        robot("tb1", **waits), robot("tb2", stopped=True, **waits), robot("tb3", battery=0.19),
        robot("tb4", battery=0.2), robot("tb5", connected=False, stopped=True, battery=0.1, **waits),
    ]  # fmt: skip
    found = await scrape(replace(NOTHING, robots=robots, longest_wait=42.0, gone=3))
    assert [found["ppaas_robots", state] for state in ("connected", "away", "queued", "gone")] == [4, 1, 0, 3]
    names = "robots_stopped", "robots_waiting", "longest_wait_seconds", "robots_battery_low"
    assert [found[(f"ppaas_{name}",)] for name in names] == [1, 1, 42, 1]
    assert not [key for key in found if key[0] in ("ppaas_robot_connected", "ppaas_robot_battery_ratio")]


async def test_robots_by_name_have_their_batteries_and_stay_bounded() -> None:
    bomb = 'a"} 1\nppaas_leader 1\n#' + "x" * 1000
    many = [robot(f"r{number}", battery=0.5) for number in range(MOST_SERIES)]
    found = await scrape(replace(NOTHING, robots=[robot(bomb, battery=0.25), robot("quiet"), *many]), robots=True)
    assert found[("ppaas_leader",)] == 0
    [cut] = [key[1] for key in found if key[0] == "ppaas_robot_battery_ratio" and key[1].startswith("a")]
    assert cut == bomb[:LONGEST_LABEL].replace("\n", "?")
    assert ("ppaas_robot_battery_ratio", "quiet", "ann") not in found
    assert found["ppaas_robot_connected", "quiet", "ann"] == 1
    assert sum(key[0] == "ppaas_robot_connected" for key in found) == MOST_SERIES + 1


async def test_plans_and_their_times_are_a_histogram_and_counters() -> None:
    counts = ControlCounts()
    counts.machine_worked("m1", {})
    counts.machine_worked("m1", {CLASSES[0]: 2, CLASSES[-1]: 1, PLAN_MICROS: 90_000_000, FAILED: 4})
    found = await scrape(replace(NOTHING, counts=counts))
    buckets = [found["ppaas_plan_seconds_bucket", limit] for limit in ("0.0005", "30.0", "+Inf")]
    assert (buckets, found[("ppaas_plan_seconds_sum",)]) == ([2, 2, 3], 90)
    origins = ("computed", "reused", "stitched", "failed")
    assert [found["ppaas_plans_total", origin] for origin in origins] == [3, 0, 0, 4]


async def test_webhooks_have_their_queue_and_what_became_of_attempts() -> None:
    numbers = WebhookNumbers(Counter({"enabled": 2}), {"waiting": 7, "dead": 1}, {"delivered": 5, "given up": 1}, 9)
    found = await scrape(replace(NOTHING, webhooks=numbers))
    assert [found["ppaas_webhooks", state] for state in ("enabled", "paused", "disabled")] == [2, 0, 0]
    assert [found["ppaas_webhook_deliveries", state] for state in ("waiting", "dead")] == [7, 1]
    assert [found["ppaas_webhook_attempts_total", result] for result in ("delivered", "given up")] == [5, 1]
    assert found[("ppaas_webhook_events_lost_total",)] == 9


@pytest.mark.parametrize("ends", [None, 1.8e9])
async def test_a_cloud_with_tls_has_the_end_of_its_certificate(ends: float | None) -> None:
    found = await scrape(replace(NOTHING, certificate_ends=ends))
    assert found.get(("ppaas_certificate_end_seconds",)) == ends
