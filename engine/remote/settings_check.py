"""Check of the settings of a cloud on a machine that joins it: by its agent, and by its endpoints."""

from engine.protocols.versions import agree
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.machines import check_reachable
from storage.urls.opening import check_exists


def check_protocols(settings: ClusterSettings) -> None:
    """Raise ``Conflict`` if this process speaks no protocol of the cloud."""
    agree("the cloud", settings.release, settings.protocols)


def check_settings(settings: ClusterSettings) -> None:
    """Check that a machine can use the settings.

    Raises
    ------
    Conflict
        This machine speaks no protocol of the cloud.
    InvalidInput, NotFound
        The stores of the cloud cannot be reached from here.
    """
    check_protocols(settings)
    for url in (settings.store, settings.map_store):
        check_reachable(url)
        check_exists(url)  # opening a path that is not shared would create an empty store
