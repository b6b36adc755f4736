"""An operator: sends a goal to a robot and waits for the result.

python send_goal.py ROBOT X Y [YAW]     metres and radians; reads PPAAS_URL and PPAAS_TOKEN from the environment
"""

import asyncio
import os
import sys

from ppaas.geometry import Pose2D
from robots.client import MoveBaseClient, RobotClient


async def main(robot, x, y, yaw=0.0):
    url = os.environ.get("PPAAS_URL", "http://127.0.0.1:8500")
    async with RobotClient(url, robot=robot, token=os.environ["PPAAS_TOKEN"], role="operator") as client:
        move_base = await MoveBaseClient(client).start()
        here = await move_base.localized()
        print(f"{robot} is at x={here.x:.2f} y={here.y:.2f}")
        outcome = await move_base.go(Pose2D(x, y, yaw))
        print(f"{outcome.status.name} after {outcome.seconds:.1f} s: {outcome.text}")
        return 0 if outcome.reached else 1


if len(sys.argv) not in (4, 5):
    sys.exit(__doc__)
sys.exit(asyncio.run(main(sys.argv[1], *map(float, sys.argv[2:]))))
