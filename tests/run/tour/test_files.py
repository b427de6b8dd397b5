"""The files of a tour."""

import numpy as np

from pipeline.export.csv import read_csv
from pipeline.run.tour.files import joined


def test_motions_go_on_in_one_table():
    """The row at which one ends and the next begins is there once, and time goes on; all else stays as written."""
    one, other = "t_s,q1_m\n0.000,0.5\n0.010,0.6\n", "t_s,q1_m\n0.000,0.6\n0.010,0.7\n0.020,0.8000\n"
    text = joined([one, other, one], np.array([0.01, 0.03, 0.04]))
    assert text == "t_s,q1_m\n0.000,0.5\n0.010,0.6\n0.020,0.7\n0.030,0.8000\n0.040,0.6\n"
    np.testing.assert_allclose(np.diff(read_csv(text)["t_s"]), 0.01)
