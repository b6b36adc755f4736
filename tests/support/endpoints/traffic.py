"""Traffic of the robots of the fake cloud."""

from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import MapPoint, TrafficRobot, TrafficState
from tests.support.endpoints.fake_cloud import FakeCloud


def add_traffic(cloud: FakeCloud, user: str, map_id: str) -> None:
    """Give a fake cloud robots tb1, which waits for tb2, and tb2, which has no goal."""
    way = [MapPoint(1.0, 2.0), MapPoint(1.5, 2.0)]
    waiting = TrafficRobot("tb1", "waiting", 1.0, 2.0, 0.5, way, "tb2", "g1", MapPoint(4.0, 2.0), 3.5)
    header = Header(stamp=Time(100, 500_000_000), frame_id="map")
    robots = [waiting, TrafficRobot("tb2", "idle", 2.0, 2.0, 0.0, [MapPoint(2.0, 2.0)])]
    cloud.traffic_states[user, map_id] = TrafficState(header, 7, 0.5, robots, 12, 0.25)
