"""HTTP as uvicorn speaks it, but bodies are handed on as they came."""

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol


class DirectHttp(HttpToolsProtocol):
    """Hands a block of a body to the application without a copy, where those before it were taken.

    So it is with large bodies, of which no more is read until they are. uvicorn copies each block twice, into a buffer
    that grows and out of it.
    """

    def on_body(self, body: bytes) -> None:
        """Take what came of a body."""
        if self.cycle is not None and not self.cycle.body:
            self.cycle.body = b""  # type: ignore[assignment]  # what is added to nothing, and made bytes of, is itself
        super().on_body(body)
