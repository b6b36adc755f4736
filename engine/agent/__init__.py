"""Agent: the process of a machine, which supervises its containers and connects them to stores and fabric."""
