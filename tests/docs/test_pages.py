"""Numbers and names in architecture.md, data-flow.md and the decisions are those of the code."""

import re
from pathlib import Path

import pytest

from engine.agent.fleet_topics import SHARED_TOPICS, scope_of
from engine.agent.map_cache import SPARE
from engine.bootstrap import CloudConfig
from engine.container import fleet_bridge
from engine.container.container import CHECKPOINT_PERIOD
from engine.control import group_places, traffic_groups
from engine.control.planning_places import IDLE
from engine.fabric.keys import addressed_key, shared_key
from engine.links import place_link, shared_place
from engine.links.carried_session import MAX_KEPT, MAX_KEPT_BYTES
from engine.master.balancers.registry import DEFAULT as BALANCER
from engine.master.places import CRASH_LIMIT, CRASH_WINDOW, LINGER
from engine.master.quotas import Quota
from engine.protocols.control_link import StopContainer
from engine.specs.containers import ContainerSpec, MapVersion, RobotConfig
from engine.specs.cores import OVERSUBSCRIPTION
from engine.specs.machine_settings import MAX_CONTAINERS
from ppaas.nodes.topics import AMCL_POSE, CMD_VEL, TRAFFIC_GRANTS
from robots.onboard.base_controller import BaseLimits
from tests.support.documents import table, text_of
from tests.support.sources import ROOT, pyproject

ARCHITECTURE, DATA_FLOW = "docs/architecture.md", "docs/data-flow.md"
PAGES = [file.relative_to(ROOT).as_posix() for file in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]]
COMMANDS = pyproject()["project"]["entry-points"]["ppaas.commands"]
FOLDED = {
    int(number): page
    for number, page in re.findall(
        r"^\| (\d{4}) \| \[.*\]\(\.\./(design-\w+\.md)#.*\) \|$", text_of("docs/adr/README.md"), re.MULTILINE
    )
}
"""Numbers of decisions that a design page replaced, with that page."""
FILE = re.compile(r"`((?:ppaas|engine|endpoints|storage|robots|tests|docs|deploy)/[\w/.]+)`")


def states(page: str, words: str) -> bool:
    """Return whether a page contains some words, ignoring line breaks."""
    return words in re.sub(r"\s+", " ", text_of(page))


@pytest.mark.parametrize("page", PAGES)
def test_every_named_file_exists(page: str) -> None:
    assert [name for name in FILE.findall(text_of(page)) if not (ROOT / name).exists()] == []


def test_limits_of_places_and_machines_are_those_of_the_code() -> None:
    quota, config = Quota(), CloudConfig("memory:", "memory:")
    assert states(ARCHITECTURE, f"while a client is connected and {LINGER:g} s longer")
    assert states(ARCHITECTURE, f"until {IDLE:g} s after the last path")
    assert states(DATA_FLOW, f"until {IDLE:g} s after")
    assert states(ARCHITECTURE, f"track people, until {group_places.PEOPLE_LINGER:g} s after the place of the last one")
    assert states(
        ARCHITECTURE, f"take part in the traffic of the map, until {traffic_groups.TRAFFIC_LINGER:g} s after that"
    )
    assert states(ARCHITECTURE, f"die more than {CRASH_LIMIT} times in {CRASH_WINDOW:g} s is closed")
    assert OVERSUBSCRIPTION == 4.0 and states(ARCHITECTURE, "gives out four times the cores it has")
    assert states(ARCHITECTURE, f"It holds {MAX_CONTAINERS} at most")
    assert states(ARCHITECTURE, f"up to {quota.containers} containers and {quota.cores:g} cores")
    assert (config.quota, config.linger) == (quota, LINGER)
    assert states(ARCHITECTURE, f"**Balancer.** `{BALANCER}`")


def test_shared_keys_are_those_of_the_code() -> None:
    keys = re.findall(r"`(ppaas/[\w/<>]*<[\w/<>]*)`", text_of(ARCHITECTURE))
    names = dict.fromkeys(("<map>", "<user>", "<robot>"))
    shown = (
        shared_key(*("<map>", "<user>", "<robot>"), "topic"),
        addressed_key("<map>", "<user>", TRAFFIC_GRANTS.name, "<robot>"),
    )
    plain = [key.replace("%3C", "<").replace("%3E", ">") for key in shown]
    assert names.keys() >= set(re.findall(r"<\w+>", " ".join(keys)))
    [shared] = SHARED_TOPICS
    assert keys == [plain[0].replace("/topic", f"/{shared}"), plain[1]]


def test_positions_of_a_container_use_the_shared_key() -> None:
    robot = RobotConfig("tb1", "turtlebot2", (0.0, 0.0, 0.0), "dijkstra", "dwa")
    scope = scope_of(ContainerSpec("c1", "ann", MapVersion("house", "v"), 1.0, robot))
    assert scope is not None
    assert scope.shared_key(AMCL_POSE.name) == "ppaas/map/house/ann/tb1/amcl_pose"


def test_limits_of_queues_and_periods_are_those_of_the_code() -> None:
    assert states(DATA_FLOW, f"checkpoint every {CHECKPOINT_PERIOD:g} s")
    assert states(DATA_FLOW, f"position every {fleet_bridge.SHARE_PERIOD:g} s")
    assert states(DATA_FLOW, f"the next comes {fleet_bridge.SHARE_PERIOD:g} s later")
    assert states(DATA_FLOW, f"a position expires after {fleet_bridge.FRESH:g} s without a new one")
    assert states(DATA_FLOW, f"at most {shared_place.MAX_UNACKNOWLEDGED} and")
    assert states(DATA_FLOW, f"and {shared_place.MAX_UNACKNOWLEDGED_BYTES >> 20} MiB wait, then the client")
    assert states(DATA_FLOW, f"at most {MAX_KEPT} frames and {MAX_KEPT_BYTES >> 20} MiB of a client")
    assert place_link.MAX_WAITING == 1 << 20 and states(DATA_FLOW, "1 MiB waits for a slow one")
    assert states(DATA_FLOW, f"waited {CMD_VEL.expiry:g} s in its session")
    assert states(DATA_FLOW, f"none has come for {BaseLimits().timeout:g} s")


def test_times_at_the_end_of_a_container_are_those_of_the_code() -> None:
    assert states(DATA_FLOW, f"not exited after {StopContainer('c1').grace:g} s")
    assert states(DATA_FLOW, f"{LINGER:g} s for it to come back")
    assert SPARE == 4 and states(DATA_FLOW, "four others were used since its last container ended")


def test_every_decision_is_listed_with_its_title() -> None:
    index = text_of("docs/adr/README.md")
    pages = sorted((ROOT / "docs" / "adr").glob("0*.md"))
    titles = {page.name: page.read_text(encoding="utf-8").partition("\n")[0] for page in pages}
    numbers = sorted([*(int(page.name[:4]) for page in pages), *FOLDED])
    assert numbers == list(range(1, len(numbers) + 1))
    for name, title in titles.items():
        number, _, words = title.removeprefix("# ").partition(": ")
        assert f"| [{number}]({name}) | {words} |" in index


def test_every_design_page_names_the_decisions_that_it_replaces() -> None:
    pages = {page.name for page in (ROOT / "docs").glob("design-*.md")}
    assert set(FOLDED.values()) == pages
    for name in pages:
        [named] = re.findall(r"replaces the decisions\s+([^(]+)\(\[list\]", text_of(f"docs/{name}"))
        ranges = re.findall(r"(\d{4})(?:\s+to\s+(\d{4}))?", named)
        numbers = {number for first, last in ranges for number in range(int(first), int(last or first) + 1)}
        assert numbers == {number for number, page in FOLDED.items() if page == name}


@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "adr").glob("0*.md")), ids=lambda page: page.stem)
def test_a_decision_has_context_decision_and_consequences(page: Path) -> None:
    headings = re.findall(r"^## (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert headings == ["Context", "Decision", "Consequences"]


def test_the_changelog_names_every_command() -> None:
    text = text_of("CHANGELOG.md")
    assert [name for name in COMMANDS if f"`{name}`" not in text and f"`ppaas {name}`" not in text] == []


def test_what_the_table_of_places_names_is_there() -> None:
    rows = table(ARCHITECTURE, "to change", "look at")
    named = [pair for _, places in rows for pair in re.findall(r"`([\w/]+\.py)`, `(\w+)`", places)]
    assert len(named) >= len(rows)
    text = {path: (ROOT / path).read_text(encoding="utf-8") for path, _ in named}
    starts = {path: set(re.findall(r"^(?:class |def |)(\w+)", text[path], re.MULTILINE)) for path in text}
    defined = {(path, name) for path, name in named if name in starts[path]}
    assert set(named) == defined
