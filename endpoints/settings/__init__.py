"""Settings of the commands that start processes of a cloud, from a file, variables and options."""
