"""Cloud in the process of a master, without machines."""

from pathlib import Path

from engine.control.master_calls.cloud import Cloud
from engine.control.master_driver import MasterDriver
from engine.control.robot_sessions import RobotSessions
from engine.leadership.leadership import SoleMaster
from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.master.quotas import Quotas
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.start_state import READY
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore


class Lead(SoleMaster):
    """Mandate of a master that may have lost the lead."""

    def __init__(self) -> None:
        self.is_lost = False

    def leads(self) -> bool:
        """Return whether it leads still."""
        return not self.is_lost


class MasterCloud(Cloud):
    """Cloud that endpoints call, whose master may have lost the lead."""

    start = READY

    def __init__(self, folder: Path) -> None:
        quotas = Quotas()
        self.master = Master(FirstFit(), quotas)
        driver = MasterDriver(self.master, CheckpointSelection(MemoryStore()), folder, "secret")
        self.lead = driver.servers[0].mandate = Lead()
        super().__init__(driver, quotas, MemoryStore(), RobotSessions(driver, MemoryStore(), MemoryMapStore()))
