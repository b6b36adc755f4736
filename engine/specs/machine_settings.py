"""Settings of a machine by an administrator: limits, labels, draining."""

import math

import msgspec

from engine.specs.cores import OVERSUBSCRIPTION
from ppaas.errors import InvalidParameter
from storage.names import is_name

MAX_CONTAINERS = 100

MOST_CONTAINERS = 10_000
MOST_OVERSUBSCRIPTION = 64.0
MOST_LABELS = 32


class MachineSettings(msgspec.Struct, frozen=True):
    """Settings of one machine.

    Parameters
    ----------
    labels : dict of str to str
        Labels in addition to its agent's; a robot may require labels of its machine.
    max_containers : int
        Most containers.
    oversubscription : float
        Factor by which the cores given to containers may exceed the machine's cores; 1 means no sharing.
    max_memory : int, optional
        Memory for containers [bytes]. Default: all memory of the machine.
    draining : bool
        Whether it gets no new containers and its containers are moved to other machines.
    """

    labels: dict[str, str] = {}
    max_containers: int = MAX_CONTAINERS
    oversubscription: float = OVERSUBSCRIPTION
    max_memory: int | None = None
    draining: bool = False


def check_settings(settings: MachineSettings) -> MachineSettings:
    """Return the settings if they are valid.

    Raises
    ------
    InvalidParameter
        A limit is out of range, or a label is invalid.
    """
    check_labels(settings.labels)
    if not 0 <= settings.max_containers <= MOST_CONTAINERS:
        raise InvalidParameter(f"max_containers must be from 0 to {MOST_CONTAINERS}, not {settings.max_containers}")
    factor = settings.oversubscription
    if not (math.isfinite(factor) and 0.0 < factor <= MOST_OVERSUBSCRIPTION):
        raise InvalidParameter(
            f"oversubscription must be greater than 0 and at most {MOST_OVERSUBSCRIPTION:g}, not {factor}"
        )
    if settings.max_memory is not None and settings.max_memory <= 0:
        raise InvalidParameter(f"max_memory must be a positive number of bytes, not {settings.max_memory}")
    return settings


def check_labels(labels: dict[str, str]) -> None:
    """Check the keys and values of labels.

    Raises
    ------
    InvalidParameter
        There are too many labels, or one is invalid.
    """
    if len(labels) > MOST_LABELS:
        raise InvalidParameter(f"there may be at most {MOST_LABELS} labels, not {len(labels)}")
    for key, value in labels.items():
        if not (is_name(key) and is_name(value)):
            raise InvalidParameter(
                f"{key[:64]!r}={value[:64]!r} is not a valid label: key and value have 1 to 64 letters, digits, '_', "
                "'.' and '-', and begin with a letter or digit"
            )


def labels_text(labels: dict[str, str]) -> str:
    """Return labels as a text, for messages."""
    return ", ".join(f"{key}={value}" for key, value in sorted(labels.items()))
