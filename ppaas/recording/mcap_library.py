"""The library ``mcap``, which is part of the extra ``recording``."""

from types import ModuleType

from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput


def mcap_modules() -> tuple[ModuleType, ModuleType]:
    """Return the modules ``mcap.writer`` and ``mcap.records``.

    Raises
    ------
    InvalidInput
        The library is not installed; the text says how to install it.
    Unavailable
        A package of the extra is older than tried: the writer of mcap 1.4 cannot flush a recording.
    """
    check_versions("recording")
    try:
        from mcap import records, writer  # noqa: PLC0415 - of the extra recording
    except ImportError as error:
        raise InvalidInput(f"recordings need the extra recording: {install_hint('recording')}") from error
    return writer, records
