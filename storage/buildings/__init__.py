"""Buildings of users: records, and the port of stores of them."""
