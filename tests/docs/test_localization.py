"""Parameters, services and bench options in localization.md are those of the code."""

import re

from benchmarks.commands import localize
from benchmarks.localization.crowd import FARTHEST, NEAREST
from benchmarks.localization.run import BEFORE, JAM, LOST
from ppaas.localization import relocalization, sensor_model
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.pose_search import TRIES, TRIES_PER_AREA
from ppaas.localization.relocalization import AMISS, FOUND, SCANS, SPACING
from ppaas.nodes.amcl.node import GLOBAL_LOCALIZATION, NOMOTION_UPDATE
from robots.cli.command_parser import CommandParser
from tests.support.documents import text_of

PAGE = "docs/localization.md"
OURS = {
    "min_particles": "500, 2000",
    "initial_cov_xx": "0.04, 0.04, 0.02",
    "update_min_d": "0.1 m, 0.2 rad",
    "laser_max_beams": "60, over what the scan sees",
    "odom_model_type": "`diff-corrected`",
    "odom_alpha1": "0.02",
}


def test_the_defaults_are_those_of_the_parameters() -> None:
    rows = {row[0]: row[1] for row in re.findall(r"^\| `(\w+)`[^|]*\| ([^|]+) \|", text_of(PAGE), re.MULTILINE)}
    assert {name: value for name, value in rows.items() if name in OURS} == OURS
    p = AmclParameters()
    assert (p.min_particles, p.max_particles, p.update_min_d, p.update_min_a) == (500, 2000, 0.1, 0.2)
    assert (p.initial_cov_xx, p.initial_cov_yy, p.initial_cov_aa) == (0.04, 0.04, 0.02)
    assert (p.laser_max_beams, p.odom_model_type) == (60, "diff-corrected")
    assert {p.odom_alpha1, p.odom_alpha2, p.odom_alpha3, p.odom_alpha4, p.odom_alpha5} == {0.02}
    assert (p.recovery_alpha_fast, p.recovery_alpha_slow) == (0.1, 0.001)
    assert "`recovery_alpha_fast` (0.1) and `recovery_alpha_slow` (0.001)" in " ".join(text_of(PAGE).split())


def test_the_numbers_are_those_of_the_code() -> None:
    text = " ".join(text_of(PAGE).split())
    assert f"{TRIES_PER_AREA:.0f} poses for each free square metre, up to {TRIES:,}" in text
    assert f"{SPACING} m farther, with the last {SCANS} scans" in text
    assert FOUND == 0.8 and "until four fifths of the weight, of the particles" in text
    assert AMISS == 0.1 and "fast one is a tenth below" in text
    assert relocalization.LOST == 0.1 and "one in ten such robots is lost" in text
    assert f"{LOST} m or 20°" in text
    assert sensor_model.MANY == 0.25 and "more than a quarter of the beams" in text
    assert f"nearer than {sensor_model.NEAR:g} m" in text and f"go {sensor_model.BEYOND} m farther" in text
    assert f"between {NEAREST} and {FARTHEST} m" in text and f"for {JAM:.0f} s" in text
    assert f"close after {BEFORE:.0f} m" in text
    for service in (GLOBAL_LOCALIZATION, NOMOTION_UPDATE):
        assert f"`{service.name}` (`{service.type.name}`)" in text
        assert f"| `{service.name}` | `{service.type.name}` |" in text_of("docs/protocol.md")


def test_the_options_of_the_bench_exist() -> None:
    parser = CommandParser()
    localize.configure(parser)
    known = set(parser._option_string_actions)
    assert set(re.findall(r"`(?:ppaas bench localize )?(--[a-z-]+)", text_of(PAGE))) <= known
