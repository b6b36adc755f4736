"""People whom several robots see, count and follow: the case study of the paper (section VI)."""
