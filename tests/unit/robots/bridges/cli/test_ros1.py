"""The command ``ppaas bridge ros1``."""

import argparse
import sys

import pytest

from robots.bridges.cli import ros1
from robots.cli.main import main


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    ros1.configure(parser)
    return parser.parse_args(["tb1", *words])


def test_master_and_address_are_those_of_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ROS_MASTER_URI", "ROS_HOSTNAME", "ROS_IP"):
        monkeypatch.delenv(name, raising=False)
    assert (parsed().master, parsed().host) == ("http://localhost:11311", "")
    monkeypatch.setenv("ROS_MASTER_URI", "http://robot:11311")
    monkeypatch.setenv("ROS_IP", "10.0.0.2")
    assert (parsed().master, parsed().host) == ("http://robot:11311", "10.0.0.2")
    monkeypatch.setenv("ROS_HOSTNAME", "laptop")
    assert parsed().host == "laptop", "as in ROS, where it goes before ROS_IP"
    assert parsed("--master", "http://a:1", "--host", "b").host == "b"


def test_a_master_that_is_none_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bridge", "ros1", "tb1", "--token", "t", "--master", "robot:11311"]) == 1
    assert "not the URI of a master or a node: 'robot:11311'; write http://HOST:PORT" in capsys.readouterr().err


def test_what_is_not_installed_is_named(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    for module in [name for name in sys.modules if name.startswith("robots.bridges.ros1")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "h11", None)
    assert main(["bridge", "ros1", "tb1", "--token", "t"]) == 1
    assert "pip install '.[ros1]'" in capsys.readouterr().err
