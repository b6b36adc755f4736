"""Interfaces of what frames are written to: the end of a link, the connection of a client."""

from typing import Protocol, TypeVar

Frame_contra = TypeVar("Frame_contra", contravariant=True)


class FrameWriter(Protocol[Frame_contra]):
    """Writes frames to the other end of a link."""

    def write(self, frame: Frame_contra, /) -> None:
        """Queue a frame; it is lost if the link is."""
        ...

    @property
    def waiting(self) -> int:
        """Number of written bytes that are still queued."""
        ...


class FrameSink(Protocol):
    """Connection that frames are sent through."""

    @property
    def ready(self) -> bool:
        """Whether it accepts a frame now."""
        ...

    def send_frame(self, frame: bytes) -> None:
        """Send a frame; only while ready."""
        ...
