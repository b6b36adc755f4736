"""The scheduler of pytest-xdist that keeps the tests of a share together."""

from pathlib import PurePath

from xdist.scheduler import LoadScopeScheduling

from tests.ci.shares import share_of


class ShareScheduling(LoadScopeScheduling):
    """Hands out whole shares, in the order in which their tests were collected."""

    def _split_scope(self, nodeid: str) -> str:
        return share_of(PurePath(nodeid.partition("::")[0]))
