"""Whole files as items of pytest-xdist, so that a process imports a file, and collects its tests, when it runs them.

Each process of pytest-xdist collects all tests otherwise, which takes half a minute of CPU, and twice that where no
test is compiled yet. The plug-in is for processes of pytest-xdist alone: where tests are named one by one, or chosen by
what failed before, they are collected as usual.
"""

from collections.abc import Generator, Iterator
from itertools import zip_longest
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

CHOOSING = ("lf", "failedfirst", "newfirst", "stepwise")
"""Options of pytest that choose and sort tests by the run before."""


def is_wanted(config: pytest.Config) -> bool:
    """Return whether a process runs whole files."""
    is_worker = hasattr(config, "workerinput")
    return (
        is_worker and not any(config.getoption(name, False) for name in CHOOSING) and "::" not in "".join(config.args)
    )


class WholeFile(pytest.File):
    """A test file with one item.

    Parameters
    ----------
    collectors : list of pytest.Collector
        What pytest collects the file with.
    """

    def __init__(self, *, collectors: list[pytest.Collector], **arguments: object) -> None:
        super().__init__(**arguments)  # type: ignore[arg-type]
        self.collectors = collectors

    def collect(self) -> Iterator["TestsOfFile"]:
        yield TestsOfFile.from_parent(self, name="tests")


class TestsOfFile(pytest.Item):
    """All tests of a file."""

    parent: WholeFile

    def __init__(self, **arguments: object) -> None:
        super().__init__(**arguments)  # type: ignore[arg-type]
        self.add_marker(pytest.mark.timeout(0))  # each test has a limit, all of them together have none

    def tests(self) -> list[pytest.Item]:
        """Import the file and return its chosen tests; pytest reports what cannot be imported."""
        items = [item for collector in self.parent.collectors for item in self.session.genitems(collector)]
        self.config.hook.pytest_collection_modifyitems(session=self.session, config=self.config, items=items)
        return items

    def run(self, nextitem: pytest.Item | None) -> None:
        """Run the tests as if pytest had collected them, each in the place of this item."""
        session, tests = self.session, self.tests()
        if not tests:
            runtestprotocol(self, log=False, nextitem=nextitem)  # ends fixtures that the next file does not share
        place = session.items.index(self)
        for test, following in zip_longest(tests, tests[1:], fillvalue=nextitem):
            session.items[place] = test
            self.config.hook.pytest_runtest_protocol(item=test, nextitem=following)
            if session.shouldfail or session.shouldstop:
                break
        session.items[place] = self

    def runtest(self) -> None:
        """Do nothing: no test was chosen."""


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(
    file_path: Path, parent: pytest.Collector
) -> Generator[None, list[pytest.Collector], list[pytest.Collector]]:
    """Put the collectors of a file aside."""
    collectors = yield
    return [WholeFile.from_parent(parent, path=file_path, collectors=collectors)] if collectors else []


@pytest.hookimpl(wrapper=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> Generator[None, None, None]:
    """Keep all files, by whatever tests are chosen of them."""
    files = [item for item in items if isinstance(item, TestsOfFile)]
    items[:] = [item for item in items if not isinstance(item, TestsOfFile)]
    yield
    items += files


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Run the tests of a file."""
    if not isinstance(item, TestsOfFile):
        return None
    item.run(nextitem)
    return True
