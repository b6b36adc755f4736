"""Binary frames of clients: CBOR, messages as PNG, and compact frames."""
