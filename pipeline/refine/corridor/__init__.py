"""What the path may not leave: cells of the route, sides of the platform for the carts, straight lines at its ends."""
