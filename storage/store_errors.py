"""Errors of stores: the text for operators names the file or the address, the text for clients does not."""

from ppaas.errors import Unavailable

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
