"""The workspace against the space that a machine takes up."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.workspace.installation import Installation, installation_of, measure_space
from pipeline.workspace.usable import WorkspaceSetting, usable_workspace

COARSE = WorkspaceSetting(step_m=0.05)


def test_the_installation_space_is_the_box_around_the_rails(machine: Machine) -> None:
    """Wherever the machine stands; along X it goes from the first end of a rail to the last."""
    assert installation_of(machine) == Installation(2.1, 0.75, 1.5)
    moved = replace(machine, rails_m=machine.rails_m + [3.0, -1.0], travel_m=machine.travel_m + [[0.0], [0.2], [-0.1]])
    box = installation_of(moved)
    assert (box.x_m, box.y_m, box.z_m) == pytest.approx((2.4, 0.75, 1.5))
    assert (box.frame_m2, box.footprint_m2, box.volume_m3) == pytest.approx((1.125, 1.8, 2.7))


def test_ratios_are_those_of_the_union(machine: Machine) -> None:
    """Of volumes, of areas across the rails, and of the volume to the floor."""
    use, workspace = measure_space(machine, COARSE), usable_workspace(machine, COARSE)
    assert use.volume_ratio == pytest.approx(workspace.union_m3 / 2.3625)
    assert use.area_ratio == pytest.approx(workspace.union_area_m2 / 1.125)
    assert use.volume_per_footprint_m == pytest.approx(workspace.union_m3 / 1.575)


def test_ratios_without_a_unit_do_not_depend_on_the_size(machine: Machine) -> None:
    """A machine twice as large takes up and uses eight times as much; kappa has to measure moments on that scale."""
    twice = replace(
        machine,
        **{
            key: 2.0 * getattr(machine, key)
            for key in ("rails_m", "travel_m", "strokes_m", "platform_points_m", "cart_offsets_m", "lengths_m")
        },
        link_link_m=2.0 * machine.link_link_m,
        characteristic_length_m=2.0 * machine.characteristic_length_m,
        masses=None,
    )
    small = measure_space(replace(machine, masses=None), COARSE)
    large = measure_space(twice, WorkspaceSetting(step_m=0.1))
    assert large.volume_ratio == pytest.approx(small.volume_ratio, rel=1e-9)
    assert large.area_ratio == pytest.approx(small.area_ratio, rel=1e-9)
    assert large.volume_per_footprint_m == pytest.approx(2.0 * small.volume_per_footprint_m, rel=1e-9)


def test_the_step_that_takes_little_time_is_good_for_a_few_per_mille(machine: Machine) -> None:
    """Against one four times as fine, which moves the volume by less than half a per cent."""
    assert measure_space(machine).volume_m3 == pytest.approx(1.7926, rel=5e-3)


def test_rails_in_a_plane_have_no_ratio(machine: Machine) -> None:
    """There is no volume to divide by; side by side they still have a floor."""
    flat = replace(machine, rails_m=np.column_stack([machine.rails_m[:, 0], np.full(3, 1.5)]))
    use = measure_space(flat, COARSE)
    assert (use.volume_ratio, use.area_ratio) == (None, None)
    assert use.volume_per_footprint_m is not None
