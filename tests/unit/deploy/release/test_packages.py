"""Packages have the same bytes wherever and whenever they are built."""

import tarfile
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from deploy.release import packages
from deploy.release.comparison import folder_differences
from ppaas.errors import Unavailable
from tests.support.deploy.helm_tools import helm_program

HELM = helm_program()
DATE = 1_700_000_000

pytestmark = pytest.mark.skipif(HELM is None, reason="no helm: make helm")

PROJECT = """\
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "ppaas-cloud"
version = "1.2.0"
requires-python = ">=3.11"

[tool.hatch.build.targets.wheel]
packages = ["ppaas"]
"""
CHART = "apiVersion: v2\nname: ppaas\nversion: 1.2.0\n"


@pytest.fixture
def project(commit: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a checkout of a small project with one commit."""
    monkeypatch.setattr(packages, "HELM", HELM)
    monkeypatch.setenv("GIT_COMMITTER_DATE", f"{DATE} +0000")
    chart = "deploy/helm/ppaas"
    files = {"pyproject.toml": PROJECT, f"{chart}/Chart.yaml": CHART, f"{chart}/templates/b.yaml": ""}
    files |= {f"ppaas/{name}.py": "" for name in ("__init__", "z", "a")}
    root = commit(files)
    (root / chart / "templates" / "a.yaml").symlink_to("b.yaml")
    return commit({})


def times(file: Path) -> Iterator[float]:
    """Yield the times of the members of an archive in their order, those of a wheel in the time of UTC."""
    if file.suffix == ".whl":
        yield from {info.date_time for info in zipfile.ZipFile(file).infolist()}  # type: ignore[misc]
    else:
        with tarfile.open(file) as archive:
            yield from {member.mtime for member in archive}


def test_packages_are_equal_wherever_and_whenever_they_are_built(project: Path, tmp_path: Path) -> None:
    packages.build_twice("HEAD", tmp_path / "one", tmp_path / "other")
    assert list(folder_differences(tmp_path / "one", tmp_path / "other")) == []
    built = {path.name: set(times(path)) for path in (tmp_path / "one").iterdir()}
    assert built == {
        "ppaas_cloud-1.2.0-py3-none-any.whl": {(2023, 11, 14, 22, 13, 20)},
        "ppaas_cloud-1.2.0.tar.gz": {DATE},
        "ppaas-1.2.0.tgz": {DATE},
    }


def test_only_what_is_committed_is_in_them(project: Path, tmp_path: Path) -> None:
    (project / "ppaas" / "secret.py").write_text("")
    sdist, wheel, chart = packages.build("HEAD", tmp_path / "dist")
    with tarfile.open(sdist) as archive, tarfile.open(chart) as packed:
        names = [*archive.getnames(), *packed.getnames(), *zipfile.ZipFile(wheel).namelist()]
        assert packed.getmember("ppaas/templates/a.yaml").isreg(), "Helm follows links"
    assert "ppaas/a.py" in names
    assert [name for name in names if "secret" in name] == []


def test_a_revision_that_is_not_there_is_refused(project: Path, tmp_path: Path) -> None:
    with pytest.raises(Unavailable, match="nowhere"):
        packages.build("nowhere", tmp_path)


def test_a_build_that_fails_is_reported_with_its_output(
    project: Path, commit: Callable[..., Path], tmp_path: Path
) -> None:
    commit({"pyproject.toml": PROJECT.replace('version = "1.2.0"\n', "")})
    with pytest.raises(Unavailable, match="version"):
        packages.build("HEAD", tmp_path / "dist")
    with pytest.raises(Unavailable, match="no nothing-there"):
        packages.run(["nothing-there"], tmp_path, packages.HERE, DATE)
