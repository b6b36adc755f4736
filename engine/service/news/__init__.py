"""News and facts that the processes of a cloud tell each other about what is in the stores and about robots."""
