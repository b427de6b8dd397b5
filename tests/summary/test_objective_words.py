"""What objectives add up, and which programs go with them."""

import pytest

from pipeline.config.choices import RouteObjective
from pipeline.errors import ConfigError
from pipeline.summary.objective_words import ROUTE_QUANTITIES, route_quantity


def test_every_objective_has_its_words():
    """A row each; values are shown with their unit."""
    assert set(ROUTE_QUANTITIES) == set(RouteObjective)
    assert ROUTE_QUANTITIES[RouteObjective.TIME].shown(5.3891) == "5.389 s"
    assert ROUTE_QUANTITIES[RouteObjective.TIME].heading == "time of the moves (s)"
    assert ROUTE_QUANTITIES[RouteObjective.INTEGRAL].shown(695.2747) == "695.3"
    assert route_quantity({"objective_kind": "integral"}).name == "kappa integral"


def test_a_section_without_an_objective_is_of_the_sum():
    """Summaries of before there was a choice."""
    assert route_quantity({}).heading == "sum of kappa"


@pytest.mark.parametrize("objective", ["integral", "time"])
@pytest.mark.parametrize("formulation", ["paper", "compact"])
def test_programs_over_all_regions_are_refused_where_travel_costs(quick_config, vary, objective, formulation):
    """Both keys are named, and what to set them to."""
    with pytest.raises(ConfigError, match=rf"route\.formulation: is {formulation}.*route\.objective is {objective}"):
        vary(quick_config, {"route.objective": objective, "route.formulation": formulation})
