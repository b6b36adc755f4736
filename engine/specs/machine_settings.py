"""What an administrator says of a machine: how much it may be given, what it is like, whether it is given anything."""

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
        What it is like, beside what its agent said of it: a robot may ask for a machine with some labels.
    max_containers : int
        Upper limit of containers.
    oversubscription : float
        Cores that it gives away for each that it has; 1 where none is to be shared.
    max_memory : int, optional
        Bytes that it may give to containers; without it all that it has.
    draining : bool
        It is given nothing new, and what it carries is moved to others.
    """

    labels: dict[str, str] = {}
    max_containers: int = MAX_CONTAINERS
    oversubscription: float = OVERSUBSCRIPTION
    max_memory: int | None = None
    draining: bool = False


def check_settings(settings: MachineSettings) -> MachineSettings:
    """Return settings that can be meant.

    Raises
    ------
    InvalidParameter
        A limit is out of range, or a label is none.
    """
    check_labels(settings.labels)
    if not 0 <= settings.max_containers <= MOST_CONTAINERS:
        raise InvalidParameter(f"max_containers is from 0 to {MOST_CONTAINERS}, not {settings.max_containers}")
    factor = settings.oversubscription
    if not (math.isfinite(factor) and 0.0 < factor <= MOST_OVERSUBSCRIPTION):
        raise InvalidParameter(f"oversubscription is more than 0 and at most {MOST_OVERSUBSCRIPTION:g}, not {factor}")
    if settings.max_memory is not None and settings.max_memory <= 0:
        raise InvalidParameter(f"max_memory is a positive number of bytes, not {settings.max_memory}")
    return settings


def check_labels(labels: dict[str, str]) -> None:
    """Make sure that labels are names with names.

    Raises
    ------
    InvalidParameter
        There are too many, or one is none.
    """
    if len(labels) > MOST_LABELS:
        raise InvalidParameter(f"there may be {MOST_LABELS} labels, not {len(labels)}")
    for key, value in labels.items():
        if not (is_name(key) and is_name(value)):
            raise InvalidParameter(
                f"{key[:64]!r}={value[:64]!r} is no label: key and value have 1 to 64 letters, digits, '_', '.' "
                "and '-', a letter or digit first"
            )


def labels_text(labels: dict[str, str]) -> str:
    """Return labels as people write them."""
    return ", ".join(f"{key}={value}" for key, value in sorted(labels.items()))
