"""Interface of the writing end of a link."""

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
