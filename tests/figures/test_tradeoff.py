"""The curves of a trade-off."""

from pipeline.figures.tradeoff import tradeoff_figure
from tests.tradeoff.conftest import make_point


def test_a_curve_per_route_in_both_panels() -> None:
    """Duration over the integral and over the largest kappa, with every weight beside its point."""
    points = tuple(make_point(route, weight) for route in (1, 2, 3) for weight in (None, 3.0, 0.3))
    figure = tradeoff_figure(points)
    for axes, name in zip(figure.axes, ("kappa_integral", "kappa_max"), strict=True):
        assert len(axes.lines) == 3
        x, y = axes.lines[1].get_data()
        assert list(x) == [getattr(point, name) for point in points[3:6]]
        assert list(y) == [point.duration_s for point in points[3:6]]
        assert [text.get_text() for text in axes.texts] == ["no time", "3", "0.3"] * 3
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [f"route {k}: LLL RRR" for k in (1, 2, 3)]
