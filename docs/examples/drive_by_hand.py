"""An operator: drives a robot by hand for some seconds, straight ahead or backwards.

python drive_by_hand.py ROBOT SPEED SECONDS     SPEED in m/s; reads PPAAS_URL and PPAAS_TOKEN from the environment
"""

import asyncio
import os
import sys

from robots.client import RobotClient
from robots.client.teleop import driving_by_hand


async def main(robot, speed, seconds):
    url = os.environ.get("PPAAS_URL", "http://127.0.0.1:8500")
    token = os.environ["PPAAS_TOKEN"]
    async with RobotClient(url, robot=robot, token=token, role="operator") as client, driving_by_hand(client) as hand:
        for _ in range(round(20 * seconds)):
            await hand.drive(speed)
            await asyncio.sleep(0.05)
        await hand.let_go()
    print(f"drove {robot} by hand for {seconds:g} s")


if len(sys.argv) != 4:
    sys.exit(__doc__)
asyncio.run(main(sys.argv[1], *map(float, sys.argv[2:])))
