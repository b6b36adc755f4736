"""How processes of a cloud reach each other: Unix sockets on one machine, mutual TLS between machines."""
