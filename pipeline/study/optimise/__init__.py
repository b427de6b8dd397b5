"""Design by optimisation: which machine or task to try next, by what came of those tried."""
