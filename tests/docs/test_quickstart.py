"""Commands of the quickstart work as printed, from the login to a robot at its goal."""

import json
import re
from pathlib import Path

import pytest

from endpoints.accounts.tokens import TOKEN_LIFETIME
from engine.control.planning_places import IDLE
from engine.master.places import LINGER
from ppaas.localization.parameters import AmclParameters
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.parameters import read_parameters
from ppaas.robot_model.known_models import model_names
from robots.client.robot_file import RobotFile
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, text_of

QUICKSTART = "docs/quickstart.md"


def test_the_defaults_of_a_robot_file_are_those_of_the_code() -> None:
    [code] = blocks(QUICKSTART, "json")
    assert json.loads(code) == json.loads(RobotFile(map="office").encode())


def test_every_model_is_named() -> None:
    assert all(f"`{name}`" in text_of(QUICKSTART) or f'"{name}"' in text_of(QUICKSTART) for name in model_names())


def test_the_times_are_those_of_the_code() -> None:
    text = text_of(QUICKSTART)
    assert f"{TOKEN_LIFETIME / 86400:g} days" in text
    assert f"waits {LINGER:g} s" in text
    assert IDLE == 120.0 and "two minutes" in text


def test_the_example_parameters_are_valid() -> None:
    [given] = re.findall(r"`(\{.*\}\})`", text_of(QUICKSTART))
    parameters = json.loads(given)
    assert set(parameters) == {"move_base", "amcl"}
    read_parameters(MoveBaseParameters, "move_base", parameters["move_base"])
    read_parameters(AmclParameters, "amcl", parameters["amcl"])


@pytest.mark.journey
def test_the_commands_lead_from_the_login_to_a_robot_at_its_goal(cloud: RunningCloud, tmp_path: Path) -> None:
    printed = run_shell(script(QUICKSTART), tmp_path, cloud)
    assert "tb1 is at x=2.0" in printed
    assert "SUCCEEDED after" in printed
    assert ["robot", "admin", "tb1", "office"] in [line.split()[1:5] for line in printed.splitlines()]
