"""The modules that are named for the fork server exist."""

import importlib
import importlib.util

import pytest

from engine.agent.entries import ENTRIES, FREEZE, PRELOAD, loaded_before
from engine.runtimes.entries import Entry


@pytest.mark.parametrize("entry", ENTRIES, ids=ENTRIES._fields)
def test_entry_modules_and_functions_exist(entry: Entry) -> None:
    module, _, function = entry.function.partition(":")
    assert callable(getattr(importlib.import_module(module), function))
    assert [name for name in entry.of_fork_server if importlib.util.find_spec(name) is None] == []


def test_fork_server_preloads_first_and_freezes_last() -> None:
    entry = loaded_before("some.module:main", "and.more")
    assert entry.of_fork_server == (PRELOAD, "some.module", "and.more", FREEZE)
    assert entry.preload == (PRELOAD, "some.module", "and.more"), "nothing is frozen where nothing is forked"
    assert Entry("some.module:main").of_fork_server == ()
