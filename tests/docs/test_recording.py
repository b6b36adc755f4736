"""Numbers, names and typed-out commands of recording.md are those of the code."""

import re

from engine.recorder import robot_recorder
from engine.recorder.open_file import FLUSH_PERIOD
from ppaas.nodes.recorder.intake import PERIODS, SAMPLE_PERIOD
from ppaas.nodes.recorder.node import PERIOD
from ppaas.recording.parameters import HEAVY, MOST_MB, MOST_MINUTES, RecorderParameters
from ppaas.recording.writer import ABOUT, DIRECTION, PARAMETERS, ROBOT_FILE
from robots.cli.command_parser import CommandParser
from robots.cli.commands import replay, robot
from robots.replay.outcomes import FAR, FAR_TURNED
from tests.support.documents import table, text_of

PAGE = "docs/recording.md"
TEXT = re.sub(r"\s+", " ", text_of(PAGE))


def test_parameters_are_those_of_the_node() -> None:
    defaults = RecorderParameters()
    shown = {row[0].strip("`"): row[1:] for row in table(PAGE, "parameter of the node", "default", "meaning")}
    assert set(shown) == set(defaults.__struct_fields__)
    assert shown["ring_minutes"][0] == f"{defaults.ring_minutes:g}"
    assert f"at most {MOST_MINUTES:g}" in shown["ring_minutes"][1]
    assert shown["max_mb"][0] == f"{defaults.max_mb}"
    assert f"at most {MOST_MB}" in shown["max_mb"][1]


def test_numbers_are_those_of_the_code() -> None:
    assert f"segments of {robot_recorder.SEGMENT:g} s" in TEXT
    assert f"at most {robot_recorder.MOST_BYTES >> 20} MiB and takes" in TEXT
    assert f"have at most {robot_recorder.MOST_USER_BYTES >> 20} MiB" in TEXT
    assert FLUSH_PERIOD + PERIOD < 3.0 and "up to the last three seconds" in TEXT
    assert sorted(PERIODS.values()) == [0.2, 2.0] and "feedback five times a second, the plan every two" in TEXT
    assert SAMPLE_PERIOD == 5.0 and "a local costmap every five seconds" in TEXT
    assert f"more than {FAR:g} m or {FAR_TURNED:g} rad" in TEXT


def test_names_in_files_are_those_of_the_code() -> None:
    for name in (ABOUT, DIRECTION, PARAMETERS, ROBOT_FILE):
        assert f"`{name}`" in TEXT
    for topic in ("camera/*", "cloud_in", "particlecloud", "key_frames", "local_plan", "diagnostics"):
        assert topic in HEAVY and f"`{topic}`" in TEXT


def test_typed_out_commands_are_understood() -> None:
    commands = re.findall(r"^ppaas (robot|replay) ([^#&\n]*)", text_of(PAGE), re.MULTILINE)
    assert len(commands) >= 9
    for name, words in commands:
        parser = CommandParser()
        (robot if name == "robot" else replay).configure(parser)
        parser.parse_args([word.strip("'") for word in words.split()])
