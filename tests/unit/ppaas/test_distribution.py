"""Versions of installed packages beside the ranges of this project."""

from importlib import metadata

import pytest
from hypothesis import given
from hypothesis import strategies as st
from packaging.requirements import Requirement as PackagingRequirement
from packaging.version import Version

from ppaas import distribution
from ppaas.distribution import BASE, Requirement, check_versions, install_hint, misfits, read_requirement
from ppaas.errors import Unavailable
from tests.support.sources import pyproject

PROJECT = pyproject()["project"]
SHIPPED = {extra: lines for extra, lines in PROJECT["optional-dependencies"].items() if extra not in ("dev", "bench")}
LINES = [*PROJECT["dependencies"], *(line for lines in SHIPPED.values() for line in lines)]


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Return versions of packages, which tests change: all others are not installed."""
    versions: dict[str, str] = {}

    def version(package: str) -> str:
        if package not in versions:
            raise metadata.PackageNotFoundError(package)
        return versions[package]

    lines = ["websockets>=15", "uvicorn<0.55,>=0.52.4; extra == 'cloud'", "websockets<18,>=15; extra == 'cloud'",
             "tbb>=2022; (platform_machine == 'x86_64') and extra == 'cloud'"]  # fmt: skip
    monkeypatch.setattr(distribution, "requires", lambda _name: lines)
    monkeypatch.setattr(distribution, "version", version)
    return versions


@pytest.mark.parametrize("line", LINES)
def test_each_requirement_of_the_project_is_read_as_by_packaging(line: str) -> None:
    read, expected = read_requirement(line), PackagingRequirement(line)
    assert read.package == expected.name
    assert set(read.wanted.split(",")) == {str(bound) for bound in expected.specifier}
    assert {bound.operator for bound in expected.specifier} <= {">=", "<"}, "Requirement.fits knows no other sign"


@given(
    found=st.lists(st.integers(0, 20), min_size=1, max_size=4),
    least=st.lists(st.integers(0, 20), min_size=1, max_size=3),
    below=st.lists(st.integers(0, 20), min_size=1, max_size=3),
)
def test_a_version_fits_where_packaging_says_so(found: list[int], least: list[int], below: list[int]) -> None:
    version, bounds = ".".join(map(str, found)), f">={'.'.join(map(str, least))},<{'.'.join(map(str, below))}"
    assert Requirement("x", bounds).fits(version) is PackagingRequirement(f"x{bounds}").specifier.contains(version)


@pytest.mark.parametrize("found", ["16.0rc1", "16.0.dev3", "16.0+local", "16.0.post1"])
def test_of_a_version_with_a_suffix_the_release_counts(found: str) -> None:
    assert Requirement("x", ">=16,<17").fits(found)
    assert not Requirement("x", "<16").fits(found)
    assert Version(found).release == (16, 0)


def test_installed_packages_of_this_project_fit() -> None:
    assert misfits(BASE, *SHIPPED) == []


@pytest.mark.parametrize(
    ("package", "found", "needed"),
    [
        ("uvicorn", "0.38.0", ">=0.52.4,<0.55"),
        ("uvicorn", "0.55.0", ">=0.52.4,<0.55"),
        ("websockets", "14.2", ">=15,<18"),
        ("websockets", "18.0", ">=15,<18"),
        ("tbb", "2021.13", ">=2022"),
    ],
)
def test_a_package_older_or_newer_than_tried_is_named(
    installed: dict[str, str], package: str, found: str, needed: str
) -> None:
    installed.update({"uvicorn": "0.54.0", "websockets": "17.4"} | {package: found})
    with pytest.raises(Unavailable) as refusal:
        check_versions(BASE, "cloud")
    assert f"{package} {found} (needed: {needed}); run: pip install '{package}{needed}'" in str(refusal.value)
    assert str(refusal.value).count(found) == 1


def test_several_packages_are_named_with_one_command(installed: dict[str, str]) -> None:
    installed.update(uvicorn="0.38.0", websockets="18.0")
    with pytest.raises(Unavailable, match=r"pip install 'uvicorn>=0\.52\.4,<0\.55' 'websockets>=15,<18'$"):
        check_versions(BASE, "cloud")


def test_packages_of_other_extras_and_missing_ones_are_left_out(installed: dict[str, str]) -> None:
    installed.update(uvicorn="0.38.0", websockets="18.0")
    check_versions(BASE)
    installed.clear()
    check_versions(BASE, "cloud")


def test_a_checkout_that_is_not_installed_is_not_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(distribution, "NAME", "no-such-distribution-of-ppaas")
    check_versions(BASE, "cloud")


def test_the_hint_names_a_checkout_and_no_program_of_an_index() -> None:
    assert install_hint("cloud", "foxglove") == "in a checkout of ppaas, pip install '.[cloud,foxglove]'"
