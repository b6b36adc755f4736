"""Messages on many robots together: plans of fleets, and traffic."""
