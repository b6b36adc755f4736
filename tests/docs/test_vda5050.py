"""Options, names and numbers in vda5050.md are those of the code."""

import argparse
import re

from ppaas.wire.vda5050.agv.action_book import INSTANT_2, INSTANT_3
from ppaas.wire.vda5050.agv.agv import OWN_DEVIATION, REMEMBERED
from ppaas.wire.vda5050.agv.zone_book import SUPPORTED
from ppaas.wire.vda5050.agv.zone_grids import RESOLUTION, SPEED_STEP
from ppaas.wire.vda5050.codec import MAX_PAYLOAD
from ppaas.wire.vda5050.spelling import ONLY_3
from robots.bridges.cli import vda5050
from robots.bridges.vda5050.agv_bridge import MAINS
from robots.bridges.vda5050.agv_options import AgvOptions
from robots.bridges.vda5050.broker import PASSWORD
from robots.bridges.vda5050.clone_side import ACTION_TIMEOUT, POSE_AGE
from robots.bridges.vda5050.mqtt_link import KEEP_ALIVE
from tests.support.documents import text_of

PAGE = re.sub(r"\s+", " ", text_of("docs/vda5050.md"))


def test_the_options_are_those_of_the_command() -> None:
    parser = argparse.ArgumentParser()
    vda5050.configure(parser)
    known = {option for action in parser._actions for option in action.option_strings}
    shown = set(re.findall(r"`(--[a-z-]+)", PAGE))
    assert shown <= known
    assert known - shown <= {"-h", "--help", "--url", "--token", "--ca-file"}
    assert PASSWORD in PAGE


def test_the_numbers_are_those_of_the_code() -> None:
    options = AgvOptions()
    assert f"longest time between two states ({options.state_interval:g} s)" in PAGE
    assert f"time between two visualizations ({options.visualization_interval:g} s)" in PAGE
    assert f"at least within {OWN_DEVIATION:g} m" in PAGE
    assert f"of the last {REMEMBERED}" in PAGE
    assert f"no pose has come for {POSE_AGE:g} s" in PAGE
    assert f"They have {ACTION_TIMEOUT:g} s" in PAGE
    assert f"without it {MAINS:g} %" in PAGE
    assert f"after up to {round(1.5 * KEEP_ALIVE + 0.5)} s" in PAGE
    assert f"cells of {100 * RESOLUTION:g} cm" in PAGE
    assert f"in steps of {SPEED_STEP:g} m/s up to {100 * SPEED_STEP:g} m/s" in PAGE
    assert MAX_PAYLOAD == 1 << 20 and "more than 1 MiB are refused" in PAGE


def test_the_errors_are_those_of_the_code() -> None:
    shown = re.findall(r"\| ((?:`[A-Z]+_[A-Z_]+`(?:, )?)+) \| `(\w+)` \|", PAGE)
    pairs = {name: old for names, old in shown for name in re.findall(r"`(\w+)`", names)}
    assert pairs.items() <= ONLY_3["errorType"].items()
    assert ONLY_3["errorType"].keys() - pairs.keys() == {
        "INVALID_INSTANT_ACTION", "NO_ORDER_TO_CANCEL", "LOCALIZATION_ERROR",
    }  # fmt: skip


def test_the_actions_and_zones_are_those_of_the_code() -> None:
    assert all(f"`{name}`" in PAGE for name in {*INSTANT_2, *INSTANT_3})
    assert f"zones of type `{SUPPORTED[0]}` and `{SUPPORTED[1]}`" in PAGE
