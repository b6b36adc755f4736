"""TODO engine/service/links."""
