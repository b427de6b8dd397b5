"""Ball arithmetic along a path: the closures as power series, and Krawczyk inclusions over intervals of s."""
