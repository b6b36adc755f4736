"""Options of endpoints: how they serve clients. ``ppaas up`` and ``ppaas machine join`` have them."""

import argparse
import math
import os
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlsplit

from endpoints.cli import oidc_options
from endpoints.http.front_settings import allowed_origin, root_path, trusted_proxy
from ppaas.bounded import whole
from ppaas.errors import InvalidInput
from ppaas.log_lines import AS_JSON, VARIABLE

DEFAULT_PORT = 8500
MAX_PORT = 65535


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options to a command."""
    _add_config(parser)
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to listen on; :: takes all of IPv6 and IPv4 (%(default)s)"
    )
    parser.add_argument(
        "--port", type=whole(0, MAX_PORT), default=DEFAULT_PORT, help="port; 0 takes a free one (%(default)s)"
    )
    parser.add_argument(
        "--advertise",
        type=_argument(advertised_url),
        default="",
        metavar="URL",
        help="address at which robots reach the endpoints of this host without a proxy, as http://hall-2:8500: a robot "
        "whose container runs here is told, and connects here next time (none)",
    )
    parser.add_argument("--tls-cert", type=Path, metavar="FILE", help="certificate in PEM, to serve HTTPS; read again")
    parser.add_argument("--tls-key", type=Path, metavar="FILE", help="private key of --tls-cert in PEM")
    _add_front(parser)
    oidc_options.add(parser)
    _add_connections(parser)
    parser.add_argument(
        "--docs-site",
        type=Path,
        metavar="FOLDER",
        help="documentation site, as 'make docs' builds it, to serve at /docs-site/ (build/docs of a checkout)",
    )
    parser.add_argument(
        "--dead", type=_dead, default=15.0, help="seconds after which a silent connection counts as dead (%(default)s)"
    )
    _add_log(parser)
    _add_traces(parser)


def add_masters(parser: argparse.ArgumentParser) -> None:
    """Add the option with the addresses of masters to a command."""
    parser.add_argument(
        "--master",
        type=_argument(_host_and_port),
        action="append",
        default=[],
        metavar="HOST:PORT",
        help="address at which a master of this cloud may listen for machines: where one joins with a secret; may be "
        "repeated",
    )


def _host_and_port(text: str) -> str:
    from engine.protocols.address import parse_host_port  # noqa: PLC0415 - ``ppaas --help`` loads this module

    parse_host_port(text)
    return text


def _add_log(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--log-level",
        default="info",
        choices=["debug", "info", "warning", "error"],
        help="least level of the lines of the log (%(default)s)",
    )
    parser.add_argument(
        "--log-format",
        default="text",
        choices=["text", AS_JSON],
        help="lines of the log: text, or one JSON object a line (%(default)s)",
    )


def _add_traces(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--traces",
        type=_argument(_receiver),
        default="",
        metavar="URL",
        help="send traces to this receiver of OpenTelemetry by OTLP over HTTP, as http://127.0.0.1:4318 (off)",
    )


def _receiver(text: str) -> str:
    try:
        parts = urlsplit(text)
        usable = not text or (parts.scheme in ("http", "https") and parts.hostname and (parts.port or 1))
    except ValueError:
        usable = False
    if not usable or "@" in text:  # a password would be in lists of processes
        raise InvalidInput(f"give http://HOST:PORT or https://HOST:PORT of a receiver of OpenTelemetry, not {text!r}")
    return text


def take_traces(arguments: argparse.Namespace) -> None:
    """Set where this process, and those that it starts, send traces; check that they can.

    Raises
    ------
    InvalidInput
        The extra for traces is not installed, or a variable of OpenTelemetry is wrong.
    """
    from engine.tracing.recording import TRACES, check_traces  # noqa: PLC0415 - ``ppaas --help`` loads this module

    os.environ[TRACES] = arguments.traces
    if arguments.traces:
        check_traces(arguments.traces)


def take_log_format(arguments: argparse.Namespace) -> None:
    """Set the format of the log for this process, and for those that it starts."""
    os.environ[VARIABLE] = arguments.log_format


def _add_config(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="file with settings, which options and variables overrule (PPAAS_CONFIG, else /etc/ppaas/ppaas.toml if it "
        "exists)",
    )


def _add_front(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--root-path",
        type=_argument(root_path),
        default="",
        metavar="/PATH",
        help="path below which a proxy serves the cloud, whether it removes the path or not (none)",
    )
    parser.add_argument(
        "--trusted-proxy",
        type=_argument(trusted_proxy),
        action="append",
        default=[],
        metavar="ADDRESS",
        help="address or network of a proxy whose X-Forwarded-For, -Proto, -Host and -Prefix count; may be repeated",
    )
    parser.add_argument(
        "--allow-origin",
        type=_argument(allowed_origin),
        action="append",
        default=[],
        metavar="ORIGIN",
        help="let web pages of another host use the cloud, such as https://pages.example; '*' for all; may be repeated",
    )


def _argument(parse: Callable[[str], str]) -> Callable[[str], str]:
    """Return a type of arguments whose errors argparse reports."""

    def argument(text: str) -> str:
        try:
            return parse(text)
        except InvalidInput as error:
            raise argparse.ArgumentTypeError(str(error)) from error

    return argument


def _add_connections(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--max-connections",
        type=whole(1),
        metavar="NUMBER",
        help="largest number of connections of each endpoint (10000, or as many as open files allow)",
    )
    parser.add_argument(
        "--max-connections-per-address",
        type=whole(1),
        metavar="NUMBER",
        help="largest number of connections from one address (half of all)",
    )


def advertised_url(text: str) -> str:
    """Return the address of an endpoint for robots without its last slash; an empty text stands for none.

    Raises
    ------
    InvalidInput
        It is no address of HTTP.
    """
    try:
        parts = urlsplit(text)
        usable = not text or (
            parts.scheme in ("http", "https") and parts.hostname and (parts.port or 1) and not parts.query
        )
    except ValueError:
        usable = False
    if not usable:
        raise InvalidInput(f"give http://HOST:PORT or https://HOST:PORT, not {text!r}")
    return text.rstrip("/")


def seconds(text: str) -> float:
    """Return a time of at least 0 s; the type of an argument."""
    value = float(text)
    if not (math.isfinite(value) and value >= 0.0):
        raise argparse.ArgumentTypeError(f"must be at least 0 seconds, not {text}")
    return value


def _dead(text: str) -> float:
    value = seconds(text)
    if value < 1.0:
        raise argparse.ArgumentTypeError(
            f"must be at least 1 s, because live connections may be silent for so long, not {text}"
        )
    return value
