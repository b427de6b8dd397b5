"""Make the route."""

from typing import TYPE_CHECKING

from pipeline.artifacts.results.route import route_files
from pipeline.progress import Monitor
from pipeline.route import plan_route
from pipeline.route.result import Route
from pipeline.run.product import Product
from pipeline.stage import Stage
from pipeline.summary.route import route_section

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_route(results: "Results", monitor: Monitor) -> Product:
    """Search for the best route through the regions."""
    if Stage.ROUTE in results.given:
        return route_product(results, results.given[Stage.ROUTE]())
    return route_product(results, plan_route(results.config, results.machine, results.regions, monitor))


def route_product(results: "Results", route: Route) -> Product:
    """Keep the route, and make its files and summary."""
    results.keep(Stage.ROUTE, route)
    return Product(route_files(route), route_section(route))
