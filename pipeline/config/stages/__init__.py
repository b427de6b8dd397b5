"""The sections of the configuration that are the options of stages."""
