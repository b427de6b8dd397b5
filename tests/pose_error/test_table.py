"""The bound as a table."""

import numpy as np

from pipeline.export.csv import DECIMALS, format_csv, read_csv
from pipeline.pose_error import PoseError, pose_error_columns, pose_error_of
from tests.pose_error.conftest import DRIVES


def test_what_is_written_is_read_back_and_is_never_below_the_bound(of_drives: PoseError) -> None:
    """Decimals are rounded up."""
    again = pose_error_of(DRIVES, read_csv(format_csv(pose_error_columns(of_drives))))
    for name in ("position_m", "rotation_rad"):
        over = getattr(again, name) - getattr(of_drives, name)
        assert (over >= 0.0).all()
        assert over.max() <= 2.0 * 10.0**-DECIMALS
    np.testing.assert_allclose(again.edges, of_drives.edges, atol=10.0**-DECIMALS)
    np.testing.assert_allclose(again.amplification.position, of_drives.amplification.position, atol=10.0**-DECIMALS)
    np.testing.assert_allclose(
        again.amplification.rotation_radpm, of_drives.amplification.rotation_radpm, atol=10.0**-DECIMALS
    )
