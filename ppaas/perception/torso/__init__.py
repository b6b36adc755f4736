"""Detection of people in depth images by the shape of head and shoulders."""
