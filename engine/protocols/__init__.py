"""Protocols: framing, messages and handshakes of the links between processes, and their sockets."""
