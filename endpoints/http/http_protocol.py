"""HTTP protocol of uvicorn that passes request bodies on without copies."""

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol


class DirectHttp(HttpToolsProtocol):
    """Passes a block of a body to the application without a copy if the previous blocks were consumed.

    Large bodies are always read like this, because reading pauses until the application has consumed them. uvicorn
    copies each block twice, into a growing buffer and out of it.
    """

    def on_body(self, body: bytes) -> None:
        """Handle a received block of a body."""
        if self.cycle is not None and not self.cycle.body:
            self.cycle.body = b""  # type: ignore[assignment]  # b"" + block, and bytes(block), are the block itself
        super().on_body(body)
