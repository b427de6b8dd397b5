"""Where the bodies of a machine are at poses, and how far apart."""
