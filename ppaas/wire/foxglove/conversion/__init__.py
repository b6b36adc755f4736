"""Messages of a clone as Foxglove draws them, and messages of Foxglove as a clone reads them."""
