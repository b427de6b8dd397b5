"""What the path may not leave: the cells of the route, and the sides of the platform that the carts are on."""
