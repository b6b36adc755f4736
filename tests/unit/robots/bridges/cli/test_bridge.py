"""The command ``ppaas bridge``."""

import argparse
import sys

import pytest

from ppaas import distribution
from ppaas.wire.ros.graph import ROS_2_RELEASES
from robots.bridges.cli import ros1
from robots.bridges.cli.ros2 import RELEASES
from robots.cli.main import main


def test_the_bridges_are_listed_and_explain_their_options(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["bridge", "--help"])
    assert "ros2" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["bridge", "ros2", "--help"])
    assert "--namespace" in capsys.readouterr().out


@pytest.mark.parametrize(
    "options", [["--domain", "233"], ["--domain", "x"], ["--transport", "tcpros"], ["--distro", "groovy"]]
)
def test_options_that_cannot_be_are_refused(options: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["bridge", "ros2", "tb1", *options])
    assert options[0] in capsys.readouterr().err


def test_a_token_is_needed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PPAAS_TOKEN", raising=False)
    assert main(["bridge", "ros2", "tb1"]) != 0
    assert "ppaas login" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("transport", "module", "advice"),
    [
        ("dds", "cyclonedds", "pip install '.[ros2]'"),
        ("zenoh", "zenoh", "pip install '.[ros2]'"),
        ("rclpy", "rclpy", "by the Python of the robot's ROS 2"),
    ],
)
def test_what_is_not_installed_is_named(
    transport: str, module: str, advice: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    assert main(["bridge", "ros2", "tb1", "--token", "t", "--transport", transport]) == 1
    assert advice in capsys.readouterr().err


@pytest.mark.parametrize(("transport", "package", "found"), [("dds", "cyclonedds", "12.0"), ("zenoh", "xxhash", "3.4")])
def test_a_package_of_an_untried_version_is_named(
    transport: str, package: str, found: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    version = distribution.version
    monkeypatch.setattr(distribution, "version", lambda name: found if name == package else version(name))
    assert main(["bridge", "ros2", "tb1", "--token", "t", "--transport", transport]) == 1
    assert f"{package} {found} (needed: >=" in capsys.readouterr().err


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


def test_what_is_not_installed_for_ros1_is_named(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in [name for name in sys.modules if name.startswith("robots.bridges.ros1")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "h11", None)
    assert main(["bridge", "ros1", "tb1", "--token", "t"]) == 1
    assert "pip install '.[ros1]'" in capsys.readouterr().err


def test_every_known_release_may_be_named():
    assert RELEASES == ROS_2_RELEASES
