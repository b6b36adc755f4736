"""Cloud in the process of a master, without machines."""

from engine.service.news.news import News
from engine.service.news.robot_facts import FactSources
from tests.support.endpoints.fake_cloud import FakeCloud


class MasterCloud(FakeCloud):
    """Cloud that endpoints call, whose master may have lost the lead."""

    def __init__(self) -> None:
        super().__init__()
        self.news = News()
        self.fact_sources = FactSources()
        self.removed: set[str] = set()
        self.leads = True

    def is_removed(self, machine: str) -> bool:
        """Return whether an administrator has removed a machine."""
        return machine in self.removed
