"""A tour: certified motions from where the machine stands through many poses, and back."""

from pipeline.run.tour.drive import TourOptions, make_tour
from pipeline.run.tour.legs import Leg
from pipeline.run.tour.result import Tour
from pipeline.run.tour.stops import StopTable, read_stops

__all__ = ["Leg", "StopTable", "Tour", "TourOptions", "make_tour", "read_stops"]
