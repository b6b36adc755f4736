"""Errors of stores: the text for operators names the file or the address, the text for clients does not."""

from ppaas import __version__
from ppaas.errors import Damaged, Unavailable

NO_STORE = "a store of this cloud cannot be used now: try again later"
"""Text for clients; the reason is for the administrators, who read it in the log and with the health."""


def unusable(place: object, advice: str, public: str = NO_STORE) -> Unavailable:
    """Return the error of a store that cannot be used.

    Parameters
    ----------
    place : object
        File or address of the store.
    advice : str
        Description of the fault, with advice, for operators.
    public : str
        The same for clients.
    """
    return Unavailable(f"{place}: {advice}", public=public)


def damaged(place: str, reason: object) -> Damaged:
    """Return the error of a record that cannot be read."""
    return Damaged(f"{place} is damaged ({reason}): restore it from a backup")


def of_another_release(place: str, release: str, reason: object) -> Unavailable:
    """Return the error of a record that is as it was written, and that this release cannot read.

    Parameters
    ----------
    place : str
        Table and key of the record.
    release : str
        Release that wrote it; empty if the record does not name it.
    reason : object
        What this release cannot read.
    """
    return Unavailable(
        f"{place} is a record of another release of PPaaS ({release or 'unknown'}), which this one ({__version__}) "
        f"cannot read ({reason}): run the release that wrote it, or a newer one"
    )
