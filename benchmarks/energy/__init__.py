"""A fleet that works for a day on few chargers, beside the bound of a linear program."""
