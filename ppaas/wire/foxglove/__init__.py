"""WebSocket protocol of Foxglove without I/O: requests, answers, the state of a connection, and messages.

Source: ``docs/spec.md`` of ``foxglove/ws-protocol``. Its subprotocol is ``foxglove.websocket.v1``; servers of
``foxglove-sdk`` speak the same messages as ``foxglove.sdk.v1``.
"""
