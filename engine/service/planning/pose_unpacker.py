"""Unpacks the poses of paths. Its kernels, and those that write poses as text, are loaded at the first path."""

import asyncio
from collections.abc import Callable

from ppaas.geometry import Poses

Unpack = Callable[[bytes], Poses]


class PoseUnpacker:
    """Loads the kernels in a thread, since numba takes a third of a second, while the first container starts."""

    def __init__(self) -> None:
        self._unpack: Unpack | None = None
        self._loading: asyncio.Future[Unpack] | None = None

    def begin(self) -> None:
        """Begin to load the kernels, unless they are loaded."""
        if self._unpack is None and self._loading is None:
            self._loading = asyncio.get_running_loop().run_in_executor(None, _load)
            self._loading.add_done_callback(self._loaded)

    async def unpack(self, packed: bytes) -> Poses:
        """Return (n, 7) poses; wait for the kernels if need be.

        Raises
        ------
        MalformedMessage
            The bytes are not packed poses.
        """
        if self._unpack is None:
            self.begin()
            assert self._loading is not None
            return (await asyncio.shield(self._loading))(packed)
        return self._unpack(packed)

    def _loaded(self, loading: asyncio.Future[Unpack]) -> None:
        if not loading.cancelled() and loading.exception() is None:
            self._unpack = loading.result()
        self._loading = None


def _load() -> Unpack:
    from ppaas.planners.kernels import pose_text  # noqa: PLC0415 - imports numba; see above
    from ppaas.plans.encoding import packed_poses  # noqa: PLC0415
    from ppaas.plans.encoding.kernels import chain_code  # noqa: PLC0415

    chain_code.warm()
    pose_text.warm()
    return packed_poses.unpack_poses
