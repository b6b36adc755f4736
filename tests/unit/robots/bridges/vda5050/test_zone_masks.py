"""Masks of zones, with a clone that answers what a test says, and a cloud that takes all maps."""

from typing import Any

import pytest

from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import to_message
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import GetMapResponse, MapMetaData, OccupancyGrid
from ppaas.wire.vda5050.agv.zone_grids import keepout_mask
from ppaas.wire.vda5050.fields import Point
from ppaas.wire.vda5050.zones import Zone, Zones
from robots.bridges.vda5050 import zone_masks
from robots.bridges.vda5050.zone_masks import ZoneMasks
from robots.client.rest import RestClient

SQUARE = [Point(x=x, y=y) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))]
BLOCKED = Zones(map_id="hall", zone_set_id="z1", zones=[Zone(zone_id="a", zone_type="BLOCKED", vertices=SQUARE)])
OPEN = Zones(map_id="hall", zone_set_id="z2", zones=[])
WITHOUT_MASK = OccupancyGrid(Header(frame_id="map"), MapMetaData(0.0, 0, 0, Pose.of(Pose2D(0.0, 0.0))), [])
"""Answer of a clone whose robot's file named no mask when it was opened."""


class Cloud(RestClient):
    """Cloud that takes all maps."""

    def __init__(self) -> None:
        super().__init__("http://127.0.0.1:9", "token")

    async def upload_map(self, *_: Any, **__: Any) -> dict[str, Any]:
        return {}


class Clone:
    """Clone that answers with a grid."""

    def __init__(self, grid: OccupancyGrid) -> None:
        self.grid = grid

    @classmethod
    def of(cls, mask: GridMap) -> "Clone":
        return cls(to_message(mask))

    async def ask(self, service: str) -> bytes:
        return encode(GetMapResponse(self.grid))


async def test_zones_are_in_use_once_the_clone_has_their_marks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(zone_masks, "EFFECT_TIMEOUT", -1.0)
    masks, clone = ZoneMasks(Cloud(), "tb1", 0.2), Clone.of(keepout_mask(OPEN))
    with pytest.raises(Unavailable, match="connect the robot again"):
        await masks.use(BLOCKED, clone.ask)
    clone = Clone.of(keepout_mask(BLOCKED))
    await masks.use(BLOCKED, clone.ask)
    with pytest.raises(Unavailable):
        await masks.use(OPEN, clone.ask)


async def test_a_clone_without_masks_is_to_be_connected_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(zone_masks, "EFFECT_TIMEOUT", -1.0)
    with pytest.raises(Unavailable, match="connect the robot again"):
        await ZoneMasks(Cloud(), "tb1", 0.2).use(BLOCKED, Clone(WITHOUT_MASK).ask)
