"""TODO engine/fabric."""
