"""The command ``ppaas bridge``."""

import sys

import pytest

from ppaas import distribution
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
