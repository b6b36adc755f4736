"""``ppaas device try``: show what a lift or a door reports, send it to a floor or open it, without a cloud."""

import argparse

from ppaas.bounded import above_zero

NAME = "device"
HELP = "try a lift or a door by its URL, without a cloud"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    verb = verbs.add_parser("try", help="print the states that a device reports; send it to a floor, or open it")
    verb.add_argument("url", metavar="URL", help="URL of the device: http://10.0.0.7/lift, modbus://10.0.0.7/1, sim:")
    what = verb.add_mutually_exclusive_group()
    what.add_argument("--floor", metavar="FLOOR", help="send the lift to a floor, and let it go when it stands open")
    what.add_argument("--door", action="store_true", help="the device is a door: only show its states")
    what.add_argument("--open", action="store_true", help="the device is a door: open it, and let it close again")
    verb.add_argument(
        "--floors", metavar="FLOOR,…", default="L1,L2", help="floors of the lift, the lowest first (%(default)s)"
    )
    verb.add_argument(
        "--seconds",
        type=above_zero(3600.0),
        default=60.0,
        help="time for which states are shown, or in which the device must obey (%(default)g)",
    )
    verb.add_argument("--json", action="store_true", help="print each state as a line of JSON")
    verb.epilog = "Each state that differs from the one before is printed, with the seconds since the start."


def run(arguments: argparse.Namespace) -> int:
    """Try the device.

    Raises
    ------
    InvalidInput
        The URL or a floor is not valid.
    Unavailable
        The device reports nothing, or does not obey in time.
    """
    from endpoints.cli import device_trial  # noqa: PLC0415 - ``ppaas --help`` loads this module

    device_trial.run(arguments)
    return 0
