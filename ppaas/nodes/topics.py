"""Topics of sensors that several nodes subscribe to, and how much each says."""

from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.base import Topic

SCAN_TOPIC = Topic("scan", LaserScan)
SCAN_RATE = 80e3
"""What a laser of 360 beams and 10 Hz says, as JSON [bytes/s]."""

ODOM_TOPIC = Topic("odom", Odometry)
ODOM_RATE = 20e3
"""What odometry of 20 Hz says, as JSON with its covariances [bytes/s]."""
