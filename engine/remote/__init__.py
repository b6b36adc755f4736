"""Remote machines: how other hosts join the cloud by ticket and certificate, and stay connected over TLS."""
