"""The file and the commands of configuration.md work."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

from endpoints.cli.settings_tree import TABLES
from endpoints.settings.effective import SettingsTree
from endpoints.settings.setting import settings_of
from tests.support.documents import blocks, script, table, text_of

PAGE = "docs/configuration.md"


def test_the_file_is_good(tmp_path: Path) -> None:
    (text,) = blocks(PAGE, "toml")
    (tmp_path / "ppaas.toml").write_text(text)
    tree = SettingsTree(TABLES, tmp_path / "ppaas.toml")
    assert tree.misspelt() + [problem for table in TABLES for problem in tree.values(table)[1]] == []
    assert tomllib.loads(text).keys() == TABLES.keys()


def test_the_commands_check_show_and_explain(tmp_path: Path) -> None:
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    typed = ["bash", "-c", "set -euo pipefail\n" + script(PAGE)]
    ended = subprocess.run(typed, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "no problems in ppaas.toml" in ended.stdout
    sources = {line.split()[0]: line.split() for line in ended.stdout.splitlines() if line.startswith("up.")}
    assert sources["up.port"] == ["up.port", "8700", "PPAAS_PORT"]
    assert sources["up.linger"] == ["up.linger", "60.0", "ppaas.toml:3"]
    assert "variable  PPAAS_RETENTION" in ended.stdout and "reload    true" in ended.stdout


def test_the_table_lists_all_settings_that_are_reloaded() -> None:
    cells = [cell for _, cell in table(PAGE, "what", "settings of `[up]` that it applies")]
    listed = {name for cell in cells for name in re.findall(r"`([a-z-]+)`", f"`{cell.strip('`')}`")}
    known = {setting.name for setting in settings_of(TABLES) if setting.reloads}
    assert listed == {name for name in known if not name.startswith("oidc-")}
    assert any("all `oidc-…`" in cell for cell in cells)


def test_the_variable_of_the_data_folder_is_the_one_of_the_code() -> None:
    variables = {setting.key: setting.variable for setting in settings_of(TABLES)}
    assert f"The variable of `--data` is `{variables['up.data']}`" in " ".join(text_of(PAGE).split())
