"""Installed packages match pyproject.toml and the locks."""

import importlib
import importlib.metadata
import re
import subprocess
import sys
import zipfile
from functools import cache

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import ppaas
from ppaas.distribution import NAME
from tests.support.sources import PACKAGES, ROOT, pyproject

LOCKS = ["deploy/requirements.lock", "deploy/bootstrap.lock"]
PROJECT = pyproject()["project"]
ENTRY_POINTS = [
    (group, name, value)
    for group, entries in {"console_scripts": PROJECT["scripts"], **PROJECT["entry-points"]}.items()
    for name, value in entries.items()
]


def test_version_is_equal_everywhere():
    assert PROJECT["name"] == NAME
    assert PROJECT["version"] == ppaas.__version__ == importlib.metadata.version(NAME)


def test_base_install_has_three_dependencies():
    assert {Requirement(text).name for text in PROJECT["dependencies"]} == {"msgspec", "numpy", "websockets"}


@pytest.mark.parametrize(("group", "name", "value"), ENTRY_POINTS)
def test_every_entry_point_loads(group, name, value):
    entry = importlib.metadata.EntryPoint(name, value, group)
    loaded = entry.load()
    if group == "ppaas.commands":
        assert name == loaded.NAME
        assert loaded.HELP
        assert callable(loaded.configure)
        assert callable(loaded.run)
    elif group in ("ppaas.machine_verbs", "ppaas.bridges"):
        assert loaded.HELP
        assert callable(loaded.configure)
        assert callable(loaded.run)
    else:
        assert callable(loaded)


def test_installed_entry_points_are_those_of_the_project():
    installed = importlib.metadata.distribution(NAME).entry_points
    assert {(e.group, e.name, e.value) for e in installed} == set(ENTRY_POINTS), "run make setup"


# -- the wheel ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> list[str]:
    """Build a wheel and return the names in it."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == 0, result.stderr
    (built,) = folder.glob("*.whl")
    return zipfile.ZipFile(built).namelist()


def test_wheel_contains_only_the_packages(wheel):
    top = {name.partition("/")[0] for name in wheel}
    assert top == {*PACKAGES, f"ppaas_cloud-{ppaas.__version__}.dist-info"}


def test_the_wheel_contains_types_and_licence(wheel):
    assert {f"{package}/py.typed" for package in PACKAGES} <= set(wheel)
    assert any(name.endswith("licenses/LICENSE") for name in wheel)


def test_the_wheel_contains_every_file_of_the_dashboard(wheel):
    pages = ROOT / "endpoints" / "dashboard" / "static"
    files = {file.relative_to(ROOT).as_posix() for file in pages.rglob("*") if file.is_file()}
    assert files and files <= set(wheel)


# -- the locks ---------------------------------------------------------------------------------------------------------


def requirements(extra: str) -> list[Requirement]:
    """Return the requirements of an extra, with those of the extras in it."""
    found = [Requirement(text) for text in PROJECT["optional-dependencies"][extra]]
    inner = [inner for requirement in found if requirement.name == NAME for inner in sorted(requirement.extras)]
    return [r for r in found if r.name != NAME] + [r for name in inner for r in requirements(name)]


@cache
def pins(path: str) -> list[Requirement]:
    """Return the lines of a lock that pin a version."""
    lines = (ROOT / path).read_text(encoding="utf-8").splitlines()
    return [Requirement(line.removesuffix("\\").strip()) for line in lines if re.match(r"\w", line)]


@pytest.mark.parametrize("path", LOCKS)
def test_lock_pins_every_line_and_names_no_registry(path):
    text = (ROOT / path).read_text(encoding="utf-8")
    assert not re.search(r"://|--(extra-)?index|--find-links", text)
    assert pins(path)
    assert all(re.fullmatch(r"==[\w.]+", str(pin.specifier)) for pin in pins(path))
    assert text.count("--hash=sha256:") >= len(pins(path))


@pytest.mark.parametrize("requirement", [*map(Requirement, PROJECT["dependencies"]), *requirements("dev")], ids=str)
def test_lock_pins_the_projects_requirements(requirement):
    here = {
        canonicalize_name(pin.name): str(pin.specifier).removeprefix("==")
        for pin in pins("deploy/requirements.lock")
        if pin.marker is None or pin.marker.evaluate()
    }
    if requirement.marker is None or requirement.marker.evaluate(default_environment()):
        assert canonicalize_name(requirement.name) in here, "run make lock"
        assert requirement.specifier.contains(here[canonicalize_name(requirement.name)]), "run make lock"


MESSAGES = [
    path
    for package in (*PACKAGES, "benchmarks")
    for path in sorted((ROOT / package).rglob("*.py"))
    if path != ROOT / "ppaas" / "distribution.py"
]


def test_one_place_tells_how_to_install_an_extra():
    assert [path for path in MESSAGES if re.search(r"pip install [^\n]*\[", path.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize(
    "page", ["README.md", "CHANGELOG.md", *sorted(p.relative_to(ROOT) for p in ROOT.glob("docs/**/*.md"))], ids=str
)
def test_no_page_tells_to_install_what_an_index_has_under_a_name_like_ours(page):
    assert not re.search(r"pip install (-\S+ )*'?ppaas(?![\w-]*\.whl|[_-])", (ROOT / page).read_text(encoding="utf-8"))


def test_makefile_installs_from_the_locks():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert all(f"--require-hashes -r {path}" in makefile for path in LOCKS)


def test_every_makefile_target_has_a_rule_and_help():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    (phony,) = re.findall(r"^\.PHONY: (.*)$", makefile, re.MULTILINE)
    assert sorted(phony.split()) == sorted(re.findall(r"^([\w-]+):.*## \S", makefile, re.MULTILINE))


def test_each_module_of_a_command_is_a_command():
    """One that no entry point names would be in the wheel, with tests and documents, and nobody could run it."""
    own = set(pyproject()["project"]["entry-points"]["ppaas.commands"].values())
    modules = {f"robots.cli.commands.{path.stem}" for path in (ROOT / "robots/cli/commands").glob("[!_]*.py")}
    assert modules <= own
