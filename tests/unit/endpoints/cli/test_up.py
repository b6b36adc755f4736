"""Errors of ``ppaas up``; that it starts is tested in ``tests/e2e``."""

import os
import re
import socket
from pathlib import Path

import pytest

from endpoints.cli import up
from endpoints.cli.up import metrics_address
from endpoints.cloud_processes import server
from endpoints.cloud_processes.server import cloud_config
from engine.master.quotas import QUOTAS, Quota
from ppaas import distribution
from ppaas.log_lines import VARIABLE
from robots.cli.command_parser import CommandParser
from robots.cli.main import main


@pytest.mark.parametrize(
    "wrong",
    [
        ["--port", "65536"], ["--port", "-1"], ["--port", "http"], ["--cores", "0"], ["--cores", "1.5"],
        ["--rapyuta", "0"], ["--rapyuta", "on"], ["--linger", "-1"], ["--linger", "nan"], ["--linger", "inf"],
        ["--quota", "cakes=1"], ["--quota", "maps"], ["--quota", "maps=1.5"], ["--quota", "cores=nan"],
        ["--root-path", "ppaas"], ["--root-path", "/v1"], ["--trusted-proxy", "*"], ["--allow-origin", "pages.example"],
        ["--quota", "containers=-1"], ["--idle", "-1"], ["--dead", "0.5"], ["--dead", "nan"], ["--log-level", "loud"],
    ],
    ids=" ".join,
)  # fmt: skip
def test_up_names_the_invalid_argument(wrong: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["up", *wrong])
    assert end.value.code == 2
    assert f"argument {wrong[0]}: " in capsys.readouterr().err


def test_every_quota_can_be_set_for_all_users() -> None:
    parser = CommandParser()
    up.configure(parser)
    given = [f"--quota={name}={number}" for number, name in enumerate(QUOTAS, 1)]
    arguments = parser.parse_args([*given, "--quota=cores=0.5"])
    assert cloud_config(arguments).quota == Quota(
        **(dict(zip(QUOTAS, range(1, len(QUOTAS) + 1), strict=True)) | {"cores": 0.5})  # type: ignore[arg-type]
    )
    assert up.QUOTAS == QUOTAS


@pytest.mark.parametrize("command", [["up"], ["machine", "join"]])
def test_a_cloud_does_not_start_with_a_package_that_was_not_tried(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    version = distribution.version
    monkeypatch.setattr(distribution, "version", lambda name: "0.1" if name == "uvicorn" else version(name))
    assert main([*command, "--data", str(tmp_path)]) == 1
    error = capsys.readouterr().err
    assert error.startswith("ppaas: unavailable: ") and "uvicorn 0.1 (needed: " in error
    assert "run: pip install 'uvicorn>=" in error
    assert not any(tmp_path.iterdir())


def test_up_reports_a_port_in_use_and_the_option_to_change(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        assert main(["up", "--data", str(tmp_path), "--port", str(port)]) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"ppaas: unavailable: cannot listen: Address already in use: host 127.0.0.1, port {port}; ")
    assert "--port" in error


def test_up_reports_a_host_address_it_cannot_assign(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["up", "--data", str(tmp_path), "--port", "0", "--host", "192.0.2.1"]) == 1
    assert "cannot listen: Cannot assign requested address" in capsys.readouterr().err


def test_up_reports_a_data_folder_that_is_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "data").touch()
    assert main(["up", "--data", str(tmp_path / "data")]) == 1
    error = capsys.readouterr().err
    assert error.startswith("ppaas: invalid-input: cannot create the data folder: ")
    assert "--data" in error


@pytest.mark.parametrize("option", ["--store", "--map-store"])
def test_an_unknown_store_scheme_lists_the_known_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    assert main(["up", "--data", str(tmp_path), "--port", "0", option, "redis://host"]) == 1
    assert re.search(r"unknown scheme of a store 'redis'; known: \w+:, \w+:, \w+:\n", capsys.readouterr().err)


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        (("--tls-cert", "cloud.pem"), "give both --tls-cert and --tls-key"),
        (("--tls-key", "cloud.key"), "give both --tls-cert and --tls-key"),
        (("--tls-cert", "cloud.pem", "--tls-key", "cloud.key"), "cannot use the certificate cloud.pem"),
    ],
)
def test_tls_needs_a_certificate_and_its_key(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], given: tuple[str, ...], fault: str
) -> None:
    assert main(["up", "--data", str(tmp_path), "--port", "0", *given]) == 1
    assert fault in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "address"),
    [("9464", ("127.0.0.1", 9464)), ("0.0.0.0:0", ("0.0.0.0", 0)), ("[::1]:9464", ("::1", 9464))],
)
def test_metrics_are_served_on_this_host_alone_unless_another_is_given(text: str, address: tuple[str, int]) -> None:
    assert metrics_address(text) == address


@pytest.mark.parametrize("text", ["", "hall", "-1", "70000", "hall:", ":9464", "::1:x", "a@b:1"])
def test_no_other_text_is_an_address_of_metrics(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["up", f"--metrics={text}"])
    assert "argument --metrics: " in capsys.readouterr().err


def test_metrics_without_their_package_name_the_extra(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "find_spec", lambda _: None)
    assert main(["up", "--data", str(tmp_path), "--port", "0", "--metrics", "0"]) == 1
    assert "--metrics needs the extra metrics: " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "variable", "in_file", "taken"),
    [
        ([], "", "text", "text"), ([], "", "json", "json"), ([], "json", "text", "json"),
        (["--log-format", "text"], "json", "json", "text"), (["--log-format", "json"], "text", "text", "json"),
    ],
)  # fmt: skip
def test_the_format_of_the_log_is_a_setting_as_any_other(
    words: list[str], variable: str, in_file: str, taken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ppaas.toml").write_text(f"[up]\nlog-format = '{in_file}'\n")
    monkeypatch.setenv(VARIABLE, variable)
    seen: list[str] = []
    monkeypatch.setattr(server, "run_server", lambda _: seen.append(os.environ[VARIABLE]))
    main(["up", "--config", str(tmp_path / "ppaas.toml"), *words])
    assert seen == [taken]


def test_hosts_of_devices_are_checked_when_they_are_typed(capsys: pytest.CaptureFixture[str]) -> None:
    parser = CommandParser()
    up.configure(parser)
    assert parser.parse_args(["--device-host", "10.0.0.0/24", "--device-host", "lifts.example:8080"]).device_host == [
        "10.0.0.0/24", "lifts.example:8080",
    ]  # fmt: skip
    with pytest.raises(SystemExit):
        parser.parse_args(["--device-host", "a b"])
    assert "a host of devices is a name" in capsys.readouterr().err
