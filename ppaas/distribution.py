"""This project as it is installed: the command that installs an extra, and packages beside it of untried versions."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version

from ppaas.errors import Unavailable

NAME = "ppaas-cloud"
"""Name of the distribution; on the index of Python, ``ppaas`` is another program."""

BASE = ""
"""Name of the group of requirements without an extra, which a robot needs."""


def install_hint(*extras: str) -> str:
    """Return the words that explain how to install extras of this project.

    The project is installed from a checkout: no index has it, and a program that an index has under a name like it is
    another one.
    """
    return f"in a checkout of ppaas, pip install '.[{','.join(extras)}]'"


@dataclass(frozen=True, slots=True)
class Requirement:
    """Range of the versions of a package that this project was tried with.

    Parameters
    ----------
    package : str
        Name of its distribution.
    wanted : str
        The range as in ``pyproject.toml``, such as ``>=2,<3``.
    extra : str
        Extra that needs it, or `BASE`.
    """

    package: str
    wanted: str
    extra: str = BASE

    def fits(self, found: str) -> bool:
        """Return whether a version is in the range; of a pre-release, the release that it precedes counts."""
        bounds = re.findall(r"(>=|<)([\d.]+)", self.wanted)
        return all((_release(found) >= _release(bound)) is (sign == ">=") for sign, bound in bounds)


@dataclass(frozen=True, slots=True)
class Misfit:
    """Installed package whose version is outside the range of its requirement."""

    requirement: Requirement
    found: str

    def __str__(self) -> str:
        return f"{self.requirement.package} {self.found} (needed: {self.requirement.wanted})"


def misfits(*groups: str) -> list[Misfit]:
    """Return the installed packages that are older or newer than tried.

    Parameters
    ----------
    *groups : str
        Extras whose packages are checked, or `BASE`. Packages that are not installed are left out.
    """
    needed = [requirement for requirement in _requirements() if requirement.extra in groups]
    found = [Misfit(each, found) for each, found in _installed(needed) if not each.fits(found)]
    return list(
        {each.requirement.package: each for each in found}.values()
    )  # an extra may narrow the range of the base


def pip_command(found: Iterable[Misfit]) -> str:
    """Return the command that installs versions that fit."""
    return " ".join(["pip install", *(f"'{each.requirement.package}{each.requirement.wanted}'" for each in found)])


def check_versions(*groups: str) -> None:
    """Raise ``Unavailable`` if a package of these groups (see `misfits`) is older or newer than tried."""
    found = misfits(*groups)
    if found:
        listed = ", ".join(map(str, found))
        raise Unavailable(f"ppaas does not work with a version that is installed: {listed}; run: {pip_command(found)}")


def read_requirement(line: str) -> Requirement:
    """Read a line of a distribution's metadata (PEP 508), such as ``x[y]<3,>=2; extra == 'cloud'``."""
    head, _, marker = line.partition(";")
    package, bounds = re.fullmatch(r"([\w.-]+)(?:\[[^]]*\])?\s*(.*)", head.strip()).groups()  # type: ignore[union-attr]
    extra = re.search(r"extra\s*==\s*['\"]([\w.-]+)['\"]", marker)
    # Metadata sort the bounds by their sign; people expect the lower one first.
    wanted = ",".join(sorted((bound.strip() for bound in bounds.strip("() ").split(",")), reverse=True))
    return Requirement(package, wanted, extra[1] if extra else BASE)


def _requirements() -> list[Requirement]:
    try:
        return [read_requirement(line) for line in requires(NAME) or ()]
    except PackageNotFoundError:  # imported from a checkout that is not installed
        return []


def _installed(needed: Iterable[Requirement]) -> Iterator[tuple[Requirement, str]]:
    for requirement in needed:
        try:
            yield requirement, version(requirement.package)
        except PackageNotFoundError:
            continue


def _release(text: str) -> tuple[int, ...]:
    """Return the numbers of a release without zeros at its end; without its epoch, which none of ours has."""
    numbers = [int(number) for number in re.match(r"[\d.]*", text)[0].split(".") if number]  # type: ignore[index]
    while numbers and not numbers[-1]:
        numbers.pop()
    return tuple(numbers)
