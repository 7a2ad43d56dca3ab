"""Messages and the MCAP log that holds them."""
