"""What sensors other than lasers see, as those parts that know lasers alone can take it."""
