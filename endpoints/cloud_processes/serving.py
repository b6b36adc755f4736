"""Main function of an endpoint process: ``python -m endpoints.cloud_processes.serving``, settings on standard input.

Its keeper imports this module for its name, and not the web application.
"""

import logging
import os
import sys

from endpoints.cloud_processes.config import Config
from engine.processes.imports import without_collection
from engine.processes.private_files import keep_new_files_private
from engine.tracing.recording import begin_traces, end_traces
from ppaas.decoding import from_json
from ppaas.errors import PPaaSError
from ppaas.log_lines import log_lines

logger = logging.getLogger(__name__)

REFUSED, NO_SETTINGS = 3, 4
"""Exit statuses of an endpoint that the master refuses, and of one that gets no settings."""


def main() -> int:
    """Serve robots, operators and REST until SIGTERM, or until there was no master for a while; return the status."""
    keep_new_files_private()
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # it would search all distributions for its plug-ins
    with without_collection():
        from endpoints.cloud_processes.endpoint_process import run  # noqa: PLC0415 - the keeper does not import it

    # Last of all: a standby starts endpoints that have no settings until it leads.
    settings = sys.stdin.buffer.read()
    if not settings:  # its keeper was killed, or does not need it
        return NO_SETTINGS
    config = from_json(settings, Config)
    form = f"%(asctime)s %(levelname)s {config.name} %(name)s: %(message)s"
    log_lines(form, process=config.name, level=config.front.log_level.upper(), dates="%H:%M:%S")
    try:
        begin_traces("ppaas-endpoint", config.name)
        run(config)
    except PPaaSError as error:
        logger.error("%s: %s", error.slug, error)
        return REFUSED
    finally:
        end_traces()
    return 0


if __name__ == "__main__":
    sys.exit(main())
