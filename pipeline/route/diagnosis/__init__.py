"""Why there is no route: how far each limit has to give until one exists."""
