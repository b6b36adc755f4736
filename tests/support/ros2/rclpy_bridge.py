"""``ppaas bridge ros2`` for a Python in which this project is on the path and not installed."""

import argparse
import sys

from robots.bridges.cli import ros2


def main() -> int:
    """Run the bridge."""
    parser = argparse.ArgumentParser()
    ros2.configure(parser)
    return ros2.run(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
