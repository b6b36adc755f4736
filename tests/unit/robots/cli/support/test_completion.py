"""``ppaas completion``: what real shells offer once they have loaded the script."""

import shlex
import shutil
import subprocess
import sys

import pytest

from robots.cli.main import main
from robots.cli.support.completion import SHELLS
from tests.support.sources import pyproject

COMMANDS = pyproject()["project"]["entry-points"]["ppaas.commands"]


@pytest.fixture
def script(capsys):
    """Return a function that returns the script for a shell."""

    def printed(shell: str) -> str:
        assert main(["completion", shell]) == 0
        return capsys.readouterr().out

    return printed


def offered(script: str, line: str, folder: str = ".") -> list[str]:
    """Return what bash offers for the last word of a line, as its function for ``ppaas`` replies."""
    words = [*shlex.split(line), *[""] * line.endswith(" ")]
    asked = "\n".join(
        [
            script,
            f"COMP_WORDS=({shlex.join(words)}) COMP_CWORD={len(words) - 1}",
            "registered=$(complete -p ppaas)",
            '[[ $registered =~ -F\\ ([^ ]+) ]] && "${BASH_REMATCH[1]}" ppaas',
            "printf '%s\\n' \"${COMPREPLY[@]}\"",
        ]
    )
    ended = subprocess.run(
        ["bash", "--norc", "--noprofile"], input=asked, cwd=folder, capture_output=True, text=True, check=True
    )
    return ended.stdout.split()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("ppaas ma", ["machine", "map"]),
        ("ppaas map rev", ["reviews"]),
        ("ppaas map publish --re", ["--review", "--reader"]),
        ("ppaas machine jo", ["join"]),
        ("ppaas robot urdf p", ["put"]),
        ("ppaas completion ", list(SHELLS)),
        ("ppaas fly", []),
    ],
)
def test_bash_completes(script, line, words):
    assert sorted(offered(script("bash"), line)) == sorted(words)


def test_bash_offers_files_where_an_argument_is_one(script, tmp_path):
    (tmp_path / "office.yaml").touch()
    assert offered(script("bash"), "ppaas map publish off", str(tmp_path)) == ["office.yaml"]


def test_bash_offers_every_command_and_no_other(script):
    words = offered(script("bash"), "ppaas ")
    assert {word for word in words if not word.startswith("-")} == set(COMMANDS)


@pytest.mark.parametrize("shell", ["zsh", "tcsh"])
def test_another_shell_loads_the_script(script, shell):
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} on this machine")
    options = {"zsh": ["-f", "-c", "autoload -Uz compinit && compinit -u -D; eval \"$(cat)\"; print $_comps[ppaas]"],
               "tcsh": ["-f", "-c", "source /dev/stdin; complete ppaas"]}  # fmt: skip
    ended = subprocess.run([shell, *options[shell]], input=script(shell), capture_output=True, text=True, check=False)
    assert ended.returncode == 0 and not ended.stderr and ended.stdout


@pytest.mark.parametrize("shell", SHELLS)
def test_the_script_holds_no_token_of_whoever_prints_it(shell, monkeypatch, script):
    monkeypatch.setenv("PPAAS_TOKEN", "a-token-that-nobody-may-read")
    assert "a-token-that-nobody-may-read" not in script(shell)


def test_an_unknown_shell_is_refused_with_the_known_ones(capsys):
    with pytest.raises(SystemExit) as end:
        main(["completion", "fish"])
    assert end.value.code == 2
    assert "invalid choice: 'fish'" in capsys.readouterr().err


def test_without_shtab_the_command_reports_the_extra(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion", "bash"]) == 1
    assert "needs the extra 'completion'" in capsys.readouterr().err
