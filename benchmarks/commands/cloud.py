"""Benches of the cloud and of the programs that connect robots to it: ``ppaas bench engine``, ``service`` and more.

Each class is one bench; its entry point names it. Modules that measure are imported only when a bench runs, since
``ppaas bench --help`` loads all benches. Benches with a client in this process run it on uvloop: what is measured is
the cloud, not our own loop.
"""

import argparse
from typing import TYPE_CHECKING

from ppaas.bounded import whole
from robots.cli import event_loop
from robots.cli.benches import Measured
from robots.cli.session import add_cloud_arguments, token_of

if TYPE_CHECKING:
    from rich.progress import Progress

MOST_CONTAINERS, MOST_PLACEMENTS, MOST_MACHINES = 2_000, 1_000_000, 10_000


class EngineBench:
    """``ppaas bench engine``: start, crash and number of containers, lost machines, the master, and messages."""

    HELP = "the engine: start and recovery of containers, capacity of a machine, placements, messages, coordinators"

    PARTS = ("ready", "crowd", "crash", "lost", "messages", "people", "standby", "master")
    RUNTIMES = ("process", "docker", "ray")

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        _add_only(parser, EngineBench.PARTS)
        parser.add_argument(
            "--runtime", choices=EngineBench.RUNTIMES, default="process", help="runtime of the containers (%(default)s)"
        )
        parser.add_argument("--containers", type=whole(most=MOST_CONTAINERS), default=100, metavar="N",
                            help="containers at once on one machine (%(default)s)")  # fmt: skip
        parser.add_argument("--placements", type=whole(most=MOST_PLACEMENTS), default=10_000, metavar="N",
                            help="placements by the master (%(default)s)")  # fmt: skip
        parser.add_argument("--machines", type=whole(most=MOST_MACHINES), default=1_000, metavar="N",
                            help="machines of these placements (%(default)s)")  # fmt: skip
        _add_quick(parser)

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return the figures of the chosen parts."""
        import uvloop  # noqa: PLC0415

        from benchmarks.engine import suite  # noqa: PLC0415
        from benchmarks.engine.options import EngineOptions  # noqa: PLC0415
        from benchmarks.harness.figures import measured  # noqa: PLC0415

        options = EngineOptions(
            tuple(arguments.only or ()), arguments.quick, arguments.runtime, arguments.containers,
            arguments.placements, arguments.machines,
        )  # fmt: skip
        return measured(event_loop.run(suite.measure(options, progress), uvloop.new_event_loop))


class ServiceBench:
    """``ppaas bench service``: waiting times of a cloud's user, part by part."""

    HELP = "waiting times of a user, from the start of a cloud to driving robots"

    PARTS = (
        "startup", "first", "plans", "load", "maps", "containers", "fleet", "dashboard", "push", "teleop",
        "teleop-browser", "metrics",
    )  # fmt: skip

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        add_cloud_arguments(parser)
        parser.set_defaults(url=None)
        _add_only(parser, ServiceBench.PARTS)
        _add_quick(parser)

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return the figures of the chosen parts."""
        import uvloop  # noqa: PLC0415

        from benchmarks.harness.figures import measured  # noqa: PLC0415
        from benchmarks.service import suite  # noqa: PLC0415

        token = token_of(arguments) if arguments.url else None
        options = suite.ServiceOptions(tuple(arguments.only or ()), arguments.quick, arguments.url, token)
        return measured(event_loop.run(suite.measure(options, progress), uvloop.new_event_loop))


class ReuseBench:
    """``ppaas bench reuse``: what it saves to look for a path among those that are kept."""

    HELP = "speed-up of stored plans over computed ones"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        _add_quick(parser)

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return all figures."""
        import uvloop  # noqa: PLC0415

        from benchmarks.harness.figures import measured  # noqa: PLC0415
        from benchmarks.service import plan_reuse  # noqa: PLC0415

        return measured(event_loop.run(plan_reuse.measure(progress, arguments.quick), uvloop.new_event_loop))


class RecordingBench:
    """``ppaas bench recording``: CPU time and size of the recording of a driving robot."""

    HELP = "CPU time and size of the recording of a driving robot, beside the same drive without it"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        _add_quick(parser, "short turns")

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return all figures."""
        from benchmarks import recording  # noqa: PLC0415
        from benchmarks.harness.figures import measured  # noqa: PLC0415

        return measured(event_loop.run(recording.measure(progress, quick=arguments.quick)))


class FoxgloveBench:
    """``ppaas bench foxglove``: CPU time of the endpoint for a viewer of many robots."""

    HELP = "CPU time of a viewer of Foxglove that looks at many robots, beside foxglove-sdk's own server"

    ROBOTS, QUICK_ROBOTS = 20, 2
    """Numbers of robots."""

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        _add_quick(parser, "few robots")
        parser.add_argument("--robots", type=whole(1, 100), help=f"number of robots ({FoxgloveBench.ROBOTS})")

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return all figures."""
        from benchmarks.foxglove import measurement  # noqa: PLC0415
        from benchmarks.harness.figures import measured  # noqa: PLC0415

        robots = arguments.robots or (FoxgloveBench.QUICK_ROBOTS if arguments.quick else FoxgloveBench.ROBOTS)
        return measured(event_loop.run(measurement.measure(progress, robots, quick=arguments.quick)))


class WireBench:
    """``ppaas bench wire``: latency, CPU time and memory of endpoints."""

    HELP = "latency, CPU time and memory of endpoints, and stops, beside bare programs that carry the same frames"

    PARTS = ("latency", "cpu", "memory", "half-open", "endpoints", "stop")

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        _add_only(parser, WireBench.PARTS)
        _add_quick(parser)

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return the figures of the chosen parts."""
        import uvloop  # noqa: PLC0415

        from benchmarks.harness.figures import PartSelection, measured  # noqa: PLC0415
        from benchmarks.wire import suite  # noqa: PLC0415

        options = PartSelection(tuple(arguments.only or ()), arguments.quick)
        return measured(event_loop.run(suite.measure(options, progress), uvloop.new_event_loop))


class BoardsBench:
    """``ppaas bench boards``: rate, memory and pauses of the clients for MicroPython and Arduino."""

    HELP = "rate, memory and pauses of the clients for MicroPython and Arduino, beside JSON without them"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        _add_quick(parser)

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return all figures."""
        from benchmarks.boards import measurement  # noqa: PLC0415
        from benchmarks.harness.figures import measured  # noqa: PLC0415

        task = progress.add_task("boards", total=2)
        figures = event_loop.run(measurement.measure_micropython(quick=arguments.quick))
        progress.advance(task)
        figures += measurement.measure_arduino(quick=arguments.quick)
        progress.advance(task)
        return measured(figures)


class BridgeBench:
    """``ppaas bench bridge``: latency, CPU time and memory of the bridges, and of the MCP server."""

    HELP = (
        "latency, CPU time and memory of ppaas bridge ros2, ros1, mavlink and rmf, and ppaas mcp, beside bare messages"
    )

    MAVLINK, RMF, MCP = "mavlink", "rmf", "mcp"
    TRANSPORTS = ("zenoh", "dds", "ros1", MAVLINK, RMF, MCP)

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        _add_quick(parser)
        parser.add_argument(
            "--transport",
            choices=BridgeBench.TRANSPORTS,
            action="append",
            help="transport to measure, again for more (all)",
        )

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return all figures."""
        from benchmarks.bridge import mcp_calls, measurement, rmf_fleets, rovers  # noqa: PLC0415
        from benchmarks.harness.figures import measured  # noqa: PLC0415

        others = {
            BridgeBench.MAVLINK: rovers.measure_rover,
            BridgeBench.RMF: rmf_fleets.measure_fleet,
            BridgeBench.MCP: mcp_calls.measure_calls,
        }
        transports = list(arguments.transport or BridgeBench.TRANSPORTS)
        of_ros = [name for name in transports if name not in others]
        figures = event_loop.run(measurement.measure(progress, of_ros, quick=arguments.quick)) if of_ros else []
        for name, measure in others.items():
            if name in transports:
                figures += event_loop.run(measure(quick=arguments.quick))
        return measured(figures)


class Vda5050Bench:
    """``ppaas bench vda5050``: CPU time and memory of bridges with many robots as AGVs, and many AGVs as robots."""

    HELP = "CPU time and memory of ppaas bridge vda5050 and ppaas bridge agv with many robots, over mosquitto"

    ROBOTS, QUICK_ROBOTS = 200, 5
    """Numbers of robots."""

    SECONDS, QUICK_SECONDS = 20.0, 3.0
    """Times for which the bridge is measured [s]."""

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        _add_quick(parser, "few robots")
        parser.add_argument("--robots", type=whole(1, 500), help=f"number of robots ({Vda5050Bench.ROBOTS})")

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return all figures."""
        from benchmarks.harness.figures import measured  # noqa: PLC0415
        from benchmarks.vda5050 import measurement  # noqa: PLC0415

        robots = arguments.robots or (Vda5050Bench.QUICK_ROBOTS if arguments.quick else Vda5050Bench.ROBOTS)
        seconds = Vda5050Bench.QUICK_SECONDS if arguments.quick else Vda5050Bench.SECONDS
        presented = event_loop.run(measurement.measure(progress, robots, seconds))
        taken = event_loop.run(measurement.measure_agvs(progress, robots, seconds))
        return measured([*presented, *taken])


def _add_only(parser: argparse.ArgumentParser, parts: tuple[str, ...]) -> None:
    parser.add_argument(
        "--only",
        choices=parts,
        metavar="NAME",
        action="append",
        help=f"part to measure, again for more: {', '.join(parts)} (all)",
    )


def _add_quick(parser: argparse.ArgumentParser, what: str = "few samples") -> None:
    parser.add_argument("--quick", action="store_true", help=f"{what}: a check that it runs, not for comparison")
