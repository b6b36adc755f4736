"""Remote machines: other hosts join the cloud with a ticket, get a certificate and stay connected over TLS."""
