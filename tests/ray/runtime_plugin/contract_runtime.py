"""The runtime of processes as a machine of tests has it: its containers run what the name of the image says."""

from engine.agent.entries import loaded_before
from engine.runtimes.base import Premises
from engine.runtimes.process.control_groups import ControlGroups, own_hierarchies
from engine.runtimes.process.runtime import ProcessRuntime


class ContractRuntime(ProcessRuntime):
    """Forks containers that run ``module:function``."""

    @classmethod
    def on(cls, premises: Premises) -> "ContractRuntime":
        return cls(loaded_before(premises.image), ControlGroups(premises.instance, own_hierarchies()))
