"""Plots a recording: the map, the first plan, the driven path and the last scan.

python docs/examples/plot_recording.py drive.mcap drive.png

It needs nothing of PPaaS, but the libraries mcap, rosbags, numpy and matplotlib.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_typestore

if len(sys.argv) != 3:
    sys.exit(__doc__)
source, target = sys.argv[1:]
store = get_typestore(Stores.ROS2_JAZZY)
topics = ["/map", "/scan", "/plan", "/amcl_pose"]
last, plans, poses = {}, [], []
if not Path(source).is_file():
    sys.exit(f"there is no file {source}: record one by 'ppaas robot record ROBOT -o FILE'")
with Path(source).open("rb") as stream:
    for schema, channel, message in make_reader(stream).iter_messages(topics=topics):
        last[channel.topic] = store.deserialize_cdr(message.data, schema.name)
        if channel.topic == "/amcl_pose":
            poses.append(last[channel.topic].pose.pose)
        if channel.topic == "/plan":
            plans.append(last[channel.topic].poses)

missing = [topic for topic in topics[:2] + topics[3:] if topic not in last]
if missing:
    sys.exit(f"{source} has no message of {', '.join(missing)}: record a drive of a robot that is localized on a map")

figure, axes = plt.subplots(figsize=(8, 6.5), layout="constrained")
grid = last["/map"]
info = grid.info
x0, y0 = info.origin.position.x, info.origin.position.y
extent = (x0, x0 + info.width * info.resolution, y0, y0 + info.height * info.resolution)
cells = grid.data.reshape(info.height, info.width)
shades = np.where(cells < 0, 0.75, 1.0 - cells / 100.0)
axes.imshow(shades, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent)

scan, pose = last["/scan"], poses[-1]
heading = 2.0 * np.arctan2(pose.orientation.z, pose.orientation.w)
angles = heading + scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
x, y = pose.position.x + scan.ranges * np.cos(angles), pose.position.y + scan.ranges * np.sin(angles)
axes.scatter(x, y, s=5, color="tab:red", zorder=3, label="last scan")

driven = np.array([(each.position.x, each.position.y) for each in poses])
if plans:
    plan = np.array([(each.pose.position.x, each.pose.position.y) for each in plans[0]])
    axes.plot(*plan.T, color="tab:orange", linewidth=4, label="first plan")
else:
    print(f"{source} has no plan: the robot had no goal while it was recorded")
axes.plot(*driven.T, color="tab:blue", linewidth=1.5, label="estimated poses")
axes.plot(*driven[-1], "o", color="tab:blue", markersize=9)
axes.set(xlabel="x [m]", ylabel="y [m]", title=f"{len(poses)} scans of a recorded drive")
axes.legend(loc="upper left")
figure.savefig(target, dpi=110)
