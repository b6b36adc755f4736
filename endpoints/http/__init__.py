"""HTTP and WebSocket protocols for uvicorn, limits of request bodies, and problem responses (RFC 9457)."""
