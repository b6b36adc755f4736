"""Images of releases are built from the files of a commit, with its time, from a base with a digest."""

import os
import re
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from deploy.release import image
from deploy.release.revision import date_of
from ppaas.errors import InvalidInput, Unavailable
from tests.support.sources import ROOT

BASE = "python:3.11-slim@sha256:" + "0" * 64

PROGRAM = """\
#!/bin/sh
# Stands in for Docker: notes its arguments, and whether the last is a folder with the Dockerfile.
printf '%s\\n' "$@" >"$NOTED"
for last; do :; done
test ! -d "$last" || test -f "$last/docker/engine.Dockerfile"
exit $?
"""


@pytest.fixture(autouse=True)
def project(commit: Callable[..., Path]) -> Path:
    """Return a checkout of a small project."""
    return commit({image.DOCKERFILE: "FROM scratch\n"})


@pytest.fixture
def noted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Put a program in place of Docker; return the file to which it writes its arguments."""
    program = tmp_path / "bin" / "docker"
    program.parent.mkdir()
    program.write_text(PROGRAM)
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{program.parent}:{os.environ['PATH']}")
    monkeypatch.setenv("NOTED", str(tmp_path / "noted"))
    return tmp_path / "noted"


def test_an_image_is_built_from_the_files_of_a_commit_with_its_time(noted: Path, project: Path, tmp_path: Path) -> None:
    image.build("HEAD", tmp_path / "dist" / "image.tar", "1.2.0", BASE, ["--no-cache"])
    words = noted.read_text().splitlines()
    assert words[:2] == ["buildx", "build"]
    assert f"SOURCE_DATE_EPOCH={date_of('HEAD')}" in words
    assert f"PYTHON={BASE}" in words
    assert f"type=oci,dest={tmp_path}/dist/image.tar,rewrite-timestamp=true" in words
    assert words[-2] == "--no-cache"
    assert Path(words[-1]) != project


@pytest.mark.parametrize("base", ["python:3.11-slim", "python@sha256:00", "", "a b@sha256:" + "0" * 64])
def test_a_base_without_a_digest_is_refused(base: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no digest"):
        image.build("HEAD", tmp_path / "image.tar", "1.2.0", base)


def test_a_build_that_fails_is_reported(noted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (noted.parent / "bin" / "docker").write_text("#!/bin/sh\necho nowhere >&2\nexit 3\n")
    with pytest.raises(Unavailable, match="status 3"):
        image.build("HEAD", tmp_path / "image.tar", "1.2.0", BASE)
    with pytest.raises(Unavailable, match="python:nothing is not known: nowhere"):
        image.resolve("python:nothing")
    monkeypatch.setattr("subprocess.run", _not_there)
    with pytest.raises(Unavailable, match="no docker"):
        image.resolve("python:nothing")


def _not_there(*_words: object, **_options: object) -> None:
    raise FileNotFoundError


def test_the_digest_of_a_name_is_the_one_of_its_registry(noted: Path) -> None:
    digest = "sha256:" + "a" * 64
    (noted.parent / "bin" / "docker").write_text(f'#!/bin/sh\necho \'{{"digest": "{digest}"}}\'\n')
    assert image.resolve("python:3.11-slim") == f"python:3.11-slim@{digest}"


def test_each_stage_of_the_dockerfile_has_the_base_and_the_time_of_the_release() -> None:
    text = (ROOT / image.DOCKERFILE).read_text(encoding="utf-8")
    stages = re.findall(r"^FROM (\S+)(?: AS (\w+))?$", text, re.MULTILINE)
    names = {name for _, name in stages if name}
    assert {base for base, _ in stages} - names == {"${PYTHON}"}
    for part in re.split(r"^FROM ", text, flags=re.MULTILINE)[1:]:
        if part.startswith("${PYTHON}"):
            assert "\nARG SOURCE_DATE_EPOCH\n" in part.partition("\nRUN ")[0] + "\n"
