"""News and facts that the processes of a cloud exchange about the stores and about robots."""
