"""The scheduler of pytest-xdist that keeps the tests of a share together."""

from pathlib import PurePath
from typing import Any

import pytest
from xdist.scheduler import LoadScopeScheduling

from tests.ci.shares import share_of


class ShareScheduling(LoadScopeScheduling):
    """Hands out whole shares, in the order in which their tests were collected.

    An item may be a file whose tests nobody has counted (`tests.ci.whole_files`), so the number of tests, of which the
    terminal shows the percentage that is done, is estimated by the files that are done.
    """

    def __init__(self, config: pytest.Config, log: Any = None) -> None:
        super().__init__(config, log)
        self._done = 0

    def _split_scope(self, nodeid: str) -> str:
        return share_of(PurePath(nodeid.partition("::")[0]))

    def mark_test_complete(self, node: Any, item_index: int, duration: float = 0) -> None:
        """Note that a process has done an item."""
        super().mark_test_complete(node, item_index, duration)
        self._done += 1
        plugins = self.config.pluginmanager
        session, terminal = plugins.get_plugin("session"), plugins.get_plugin("terminalreporter")
        if session and terminal and self.collection:
            session.testscollected = terminal.reported_progress * len(self.collection) // self._done
