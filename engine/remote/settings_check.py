"""Check of the settings of a cloud on a machine that joins it: by its agent, and by its endpoints."""

from engine.remote.cluster_settings import ClusterSettings
from engine.remote.machines import check_reachable
from ppaas import __version__
from ppaas.errors import Conflict
from storage.urls.opening import check_exists


def check_settings(settings: ClusterSettings, machine: str) -> None:
    """Check that a machine can use the settings.

    Raises
    ------
    Conflict
        The cloud runs another release of this program.
    InvalidInput, NotFound
        The stores of the cloud cannot be reached from here.
    """
    if settings.release != __version__:
        raise Conflict(
            f"the cloud runs release {settings.release or '(unknown)'}, but machine {machine} runs {__version__}: "
            "install the cloud's release and start the machine again"
        )
    for url in (settings.store, settings.map_store):
        check_reachable(url)
        check_exists(url)  # opening a path that is not shared would create an empty store
