"""Each part of a release is published by the program of its registry, from files that were built."""

from pathlib import Path

import pytest

from deploy.release.__main__ import main
from deploy.release.publication import PARTS, command
from ppaas import __version__
from ppaas.errors import InvalidInput, NotFound

PROGRAMS = {name: name for name in ("uv", "skopeo", "helm", "gh")}
NAMES = {
    "wheels": ["ppaas_cloud-1.2.0.tar.gz", "ppaas_cloud-1.2.0-py3-none-any.whl"],
    "image": ["ppaas-engine-1.2.0.oci.tar"],
    "chart": ["ppaas-1.2.0.tgz"],
    "page": ["notes.md"],
}


@pytest.fixture
def built(tmp_path: Path) -> Path:
    """Return a folder with all that is published."""
    for name in (*(name for names in NAMES.values() for name in names), "ppaas_cloud.cdx.json", "base-image.txt"):
        (tmp_path / name).write_text("")
    return tmp_path


def words(part: str, folder: Path, registry: str = "ghcr.io/Owner") -> list[str]:
    return command(part, folder, "1.2.0", registry, PROGRAMS)


def test_packages_go_to_the_index_of_python(built: Path) -> None:
    files = [f"{built}/{name}" for name in NAMES["wheels"]]
    assert words("wheels", built) == ["uv", "publish", "--trusted-publishing", "automatic", *files]


def test_image_and_chart_go_to_the_registry_whose_names_are_small(built: Path) -> None:
    assert words("image", built)[-2:] == [
        f"oci-archive:{built}/ppaas-engine-1.2.0.oci.tar",
        "docker://ghcr.io/owner/ppaas-engine:1.2.0",
    ]
    assert words("chart", built) == ["helm", "push", f"{built}/ppaas-1.2.0.tgz", "oci://ghcr.io/owner/charts"]


def test_the_page_has_all_files_but_the_image(built: Path) -> None:
    line = words("page", built)
    assert line[:4] == ["gh", "release", "create", "v1.2.0"]
    files = {Path(word).name for word in line[line.index("--notes-file") + 2 :]}
    assert files == {path.name for path in built.iterdir()} - {"notes.md", "ppaas-engine-1.2.0.oci.tar"}


@pytest.mark.parametrize("part", PARTS)
def test_what_was_not_built_is_not_published(part: str, built: Path) -> None:
    (built / NAMES[part][-1]).unlink()
    with pytest.raises(NotFound, match="build it first"):
        words(part, built)


@pytest.mark.parametrize("part", ["image", "chart"])
def test_a_registry_must_be_given(part: str, built: Path) -> None:
    with pytest.raises(InvalidInput, match="--registry"):
        words(part, built, registry="")


def test_a_dry_run_prints_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / f"ppaas-{__version__}.tgz").write_text("")
    publish = ["--folder", str(tmp_path), "publish", "chart", "--registry", "r/o", "--arguments=--plain-http"]
    assert main([*publish, "--dry-run"]) == 0
    assert capsys.readouterr().out.endswith("oci://r/o/charts --plain-http\n")


def test_a_refusal_is_a_line_and_a_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--folder", str(tmp_path), "publish", "chart"]) == 1
    assert capsys.readouterr().err == "release: no registry to publish the chart at: give --registry HOST/OWNER\n"
    assert main(["--folder", str(tmp_path), "image"]) == 1
    assert "base-image.txt" in capsys.readouterr().err
