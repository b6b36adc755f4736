"""Protocols of the links between processes: framing, messages, handshakes and sockets."""
