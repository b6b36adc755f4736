"""The settings, options, routes and commands of oidc.md are those of the code."""

import os
import re
import subprocess
import sys
from pathlib import Path

from endpoints.app import OPERATIONS
from endpoints.cli.settings_tree import TABLES
from endpoints.oidc.settings import USUAL_ALGORITHMS, USUAL_SCOPES, OidcSettings
from endpoints.settings.effective import SettingsTree
from endpoints.settings.setting import settings_of
from tests.support.documents import blocks, script, table, text_of

PAGE = "docs/oidc.md"


def test_the_file_of_settings_is_good(tmp_path: Path) -> None:
    (text,) = blocks(PAGE, "toml")
    (tmp_path / "ppaas.toml").write_text(text)
    tree = SettingsTree(TABLES, tmp_path / "ppaas.toml")
    assert tree.misspelt() + tree.values("up")[1] == []
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    typed = ["bash", "-c", "set -euo pipefail\n" + script(PAGE)]
    ended = subprocess.run(typed, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "") and "no problems" in ended.stdout


def test_the_table_lists_all_options_with_their_defaults() -> None:
    defaults = {option: default for option, default, _ in table(PAGE, "option", "default", "what")}
    known = {each.flag: each for each in settings_of({"up": TABLES["up"]}) if each.flag.startswith("--oidc-")}
    assert defaults.keys() == known.keys()
    of_code = OidcSettings(issuer="", client_id="", cloud_url="", roles=())
    assert defaults["--oidc-leeway"] == f"{of_code.leeway:g}" == f"{known['--oidc-leeway'].action.default:g}"
    assert defaults["--oidc-session"] == f"{of_code.session:.0f}" == f"{known['--oidc-session'].action.default:.0f}"
    for flag in ("--oidc-groups-claim", "--oidc-username-claim"):
        field = flag.removeprefix("--oidc-").replace("-", "_")
        assert defaults[flag] == getattr(of_code, field) == known[flag].action.default
    assert re.findall(r"`(\w+)`", defaults["--oidc-scope"]) == list(USUAL_SCOPES)
    assert re.findall(r"`(\w+)`", defaults["--oidc-algorithm"]) == list(USUAL_ALGORITHMS)


def test_the_routes_are_all_of_the_code() -> None:
    named = {cell.strip("`") for cell, _ in table(PAGE, "request", "what")}
    assert named == {f"{method} {path}" for path, methods in OPERATIONS if "/oidc" in path for method in methods}


def test_the_options_of_commands_exist() -> None:
    named = set(re.findall(r"--\w[\w-]*", text_of(PAGE)))
    known: set[str] = set()
    for command in (["up"], ["login"], ["user", "link"]):
        printed = subprocess.run(
            [sys.executable, "-m", "robots.cli", *command, "--help"], capture_output=True, text=True, check=True
        )
        known |= set(re.findall(r"--\w[\w-]*", printed.stdout))
    assert named <= known
