"""The file of a certificate: its shape, its bounds, what is read of it without trust, and what is written."""
