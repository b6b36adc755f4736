"""The page about graphs: its commands work, and its options, properties and numbers are those of the code."""

import argparse
import re
from pathlib import Path

import pytest

from ppaas.imports.graphs.formats.lif_file import VERSION
from ppaas.imports.graphs.formats.nav2_route import ABSOLUTE_SPEED, SPEED
from ppaas.imports.graphs.model.route_graph import MAX_FILE, GraphOptions
from ppaas.imports.graphs.reading import import_graph
from ppaas.imports.graphs.rmf.fields import PASSING, USES
from ppaas.imports.graphs.to_zones import BESIDE
from ppaas.zones.zone import MOST_ON_LANES
from robots.cli.verbs import map_graphs
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import run_shell, script, table, text_of
from tests.support.graphs import segments_of
from tests.support.sources import ROOT

PAGE = "docs/graphs.md"
EXAMPLES = ROOT / "docs" / "examples" / "graphs"


def test_the_options_are_those_of_the_command() -> None:
    parser = argparse.ArgumentParser()
    verbs = parser.add_subparsers()
    map_graphs.configure(verbs)
    known = {name for action in verbs.choices["import-graph"]._actions for name in action.option_strings}
    named = {name for row in table(PAGE, "option", "meaning") for name in re.findall(r"--[a-z]+", row[0])}
    assert named <= known
    written = verbs.choices["export-graph"]._actions
    common = {name for action in written for name in action.option_strings}
    assert known - named - common == {"--dry-run", "--message", "--if-match"}


def test_properties_and_numbers_are_those_of_the_code() -> None:
    page = re.sub(r"\s+", " ", text_of(PAGE))
    rmf = dict(table(PAGE, "in the building", "here"))
    [named] = [key for key in rmf if "is_charger" in key]
    assert re.findall(r"`(\w+)`", named) == list(USES)
    assert re.findall(r"`(\w+)`", rmf[named]) == list(USES.values())
    assert PASSING in rmf
    nav2 = " ".join(key for key, _ in table(PAGE, "in the file", "here"))
    assert f"`{SPEED}` below 1" in nav2
    assert f" {ABSOLUTE_SPEED} " in nav2
    assert f"writes version {VERSION}, valid" in page
    assert f"zones along the lanes, {2 * BESIDE:g} m wide" in page
    assert f"[{MOST_ON_LANES} positions on lanes]" in page
    assert f"Files may have {MAX_FILE >> 20} MiB" in page


def test_the_examples_are_the_same_lanes_in_three_formats() -> None:
    found = [
        import_graph((EXAMPLES / name).read_bytes(), name, options)[0]
        for name, options in (
            ("office.geojson", GraphOptions()),
            ("office.lif.json", GraphOptions()),
            ("office.building.yaml", GraphOptions(shift=(0.0, 10.0, 0.0))),
        )
    ]
    assert segments_of(found[0]) == segments_of(found[1]) == segments_of(found[2])
    for zones in found:
        assert [zone.name for zone in zones.stations] == ["store room", "kitchen", "meeting room"]


@pytest.mark.journey
def test_the_commands_work(own_cloud: RunningCloud, tmp_path: Path) -> None:
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    printed = run_shell(f"{login}\n{script(PAGE)}\nppaas map zones office", tmp_path, own_cloud)
    assert (tmp_path / "lanes.png").is_file()
    assert "pick_drop" in printed
    assert re.search(r"^meeting door +capacity +1 robot", printed, re.MULTILINE)
    assert re.search(r"^store room +station +park, pick", printed, re.MULTILINE)
    layout, _ = import_graph((tmp_path / "office.lif.json").read_bytes(), "office.lif.json")
    routes, _ = import_graph((tmp_path / "office.geojson").read_bytes(), "office.geojson")
    given, _ = import_graph((EXAMPLES / "office.lif.json").read_bytes(), "office.lif.json")
    assert segments_of(layout) == segments_of(routes) == segments_of(given)
