"""The commands, one module per group; each lists its commands with examples in `COMMANDS`."""
