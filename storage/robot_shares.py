"""Shares of robots, which are part of the record of a robot in all stores."""

from abc import ABC, abstractmethod

from msgspec.structs import replace

from storage.records import RobotRecord
from storage.sharing_records import Share, check_grantee


class RobotShares(ABC):
    """The part of a ``RobotStore`` that changes shares."""

    @abstractmethod
    def put_robot(self, record: RobotRecord, *, instead_of: RobotRecord | None = None) -> bool:
        """Store a robot; ``Conflict`` if the stored record is not ``instead_of``."""

    def change_shares(self, record: RobotRecord, shares: tuple[Share, ...]) -> RobotRecord:
        """Share a robot with these users and groups alone; ``Conflict`` if the stored record is not ``record``."""
        for share in shares:
            check_grantee(share.to)
        changed = replace(record, shares=shares)
        self.put_robot(changed, instead_of=record)
        return changed
