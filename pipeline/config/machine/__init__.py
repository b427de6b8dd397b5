"""The machine's section of the configuration."""
