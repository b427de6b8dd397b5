"""The costs of moves that the objectives of stage one add up."""
