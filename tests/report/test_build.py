"""What a report says: the figures of the run, the motion as it is driven, kappa as it is."""

import base64
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.certify.bounds import Ranges
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.figures.maps.kappa_map import kappa_map
from pipeline.limits.bodies.pairs import kept_apart, pair_distances
from pipeline.machine import Machine, inverse_kinematics, statics_matrix
from pipeline.machine.geometry import ACTUATORS, MODES
from pipeline.machine.samples import PoseSamples
from pipeline.report import Report, RunResults, build_report
from pipeline.report.motion import build_scene, singular_loops
from pipeline.report.payload import OUT_OF_REACH, levels, packed, payload
from pipeline.report.tables import build_proof, distances_table, drives_table
from pipeline.report.verdicts import headline, used_limits, verdicts
from pipeline.retime import Trajectory
from pipeline.stage import Stage


class TestMotion:
    """The machine in motion."""

    def test_links_keep_their_lengths(self, report: Report, machine: Machine) -> None:
        """At every instant of both motions the links of fixed length have it, and telescopes that of their actuator."""
        for motion in report.motions:
            lengths = np.linalg.norm(motion.platform_joints_m - motion.cart_joints_m, axis=2)
            fixed = ~np.isnan(machine.lengths_m)
            assert np.allclose(lengths[:, fixed], machine.lengths_m[fixed], atol=1e-9)
            assert np.allclose(lengths[:, ~fixed], motion.q_m[:, 3:], atol=1e-9)

    def test_motions_begin_and_end_at_rest(self, report: Report, complete: RunResults) -> None:
        """Both motions go from the same pose at rest to the same pose at rest, in whole periods."""
        refined, coarse = report.motions
        for motion in report.motions:
            assert np.allclose(motion.qd_mps[[0, -1]], 0.0, atol=1e-9)
            assert motion.t_s[-1] == pytest.approx(round(motion.t_s[-1] / 0.01) * 0.01)
        assert np.allclose(refined.pose[[0, -1]], coarse.pose[[0, -1]], atol=1e-9)

    def test_carts_stand_on_their_rails(self, report: Report, machine: Machine) -> None:
        """Feet are on the rails, at the position of their cart."""
        feet = report.motions[0].feet_m
        assert np.array_equal(feet[:, :, 1:], np.broadcast_to(machine.rails_m, (len(feet), 3, 2)))
        assert np.array_equal(feet[:, :, 0], report.motions[0].q_m[:, :3])

    def test_maps_hold_kappa_of_the_motion(self, report: Report) -> None:
        """Interpolated at the TCP, each map has nearly the kappa of the motion at its instant."""
        motion = report.motions[0]
        maps = motion.maps
        for instant in range(0, len(maps.t_s), 10):
            frame = int(np.argmin(np.abs(motion.t_s - maps.t_s[instant])))
            y, z = motion.pose[frame, 1:3]
            i, j = int(np.argmin(np.abs(maps.z_m - z))), int(np.argmin(np.abs(maps.y_m - y)))
            around = maps.kappa[instant, i - 1 : i + 2, j - 1 : j + 2]
            assert np.nanmin(around) <= motion.kappa[frame] <= np.nanmax(around)

    def test_the_platform_is_drawn_as_bars_or_bodies(
        self, machine: Machine, bodies_machine: Machine, quick_config: Config, bodies_config: Config
    ) -> None:
        """Bars are there in any case; bodies, and the two of every pair, where they are declared."""
        bare, scene = build_scene(quick_config, machine), build_scene(bodies_config, bodies_machine)
        assert len(bare.platform_bars) == len(scene.platform_bars) == 6
        assert bare.meshes == bare.pairs == ()
        assert scene.alarm_m == pytest.approx(0.01)
        for name, (first, second) in zip(scene.pair_names, scene.pairs, strict=True):
            assert name == f"{scene.meshes[first].name} and {scene.meshes[second].name}"

    def test_the_nearest_pair_is_that_of_each_instant(
        self, bodies_report: Report, bodies_config: Config, bodies_machine: Machine
    ) -> None:
        """Its distance is the least of all bodies, that of all obstacles, and the less of these is of all pairs."""
        motion = bodies_report.motions[0]
        names, kept = bodies_report.scene.pair_names, kept_apart(bodies_config, bodies_machine)
        assert [group.of for group in motion.nearest] == ["bodies", "obstacles"]
        for frame in range(0, len(motion.t_s), 40):
            samples = PoseSamples(bodies_machine, motion.pose[[frame]], motion.q_m[[frame]])
            distances = dict(zip(names, pair_distances(kept, samples)[0], strict=True))
            for group, bodies in zip(motion.nearest, kept, strict=True):
                pair, least = names[group.pair[frame]], min(distances[name] for name in bodies.names)
                assert distances[pair] == least == pytest.approx(group.distance_m[frame], abs=1e-9)
            number, distance_m = motion.nearest_at(frame)
            assert distances[names[number]] == min(distances.values()) == pytest.approx(distance_m, abs=1e-9)


class TestLoops:
    """Curves of det H = 0."""

    def test_they_are_singular(self, machine: Machine) -> None:
        """On the curves |det H| is small against what it is elsewhere on the map."""
        mode, tilt = MODES.index("LRL"), (np.deg2rad(-24.0), np.deg2rad(-14.0))
        a_map = kappa_map(machine, np.linspace(-0.4, 0.9, 120), np.linspace(0.5, 1.3, 100), tilt, mode)
        loops = singular_loops(a_map)
        points = loops[~np.isnan(loops[:, 0])]
        assert len(points) > 20
        controlled = np.column_stack([np.zeros(len(points)), points, np.tile(tilt, (len(points), 1))])
        solution = inverse_kinematics(machine, controlled, np.full(len(points), mode))
        known = solution.reachable
        det = np.linalg.det(statics_matrix(machine, solution.pose[known], solution.q_m[known, :3]))
        assert np.median(np.abs(det)) < 1e-3 * np.nanmax(np.abs(a_map.det))

    def test_there_are_none_without_singularities(self, machine: Machine) -> None:
        """A map whose determinant keeps its sign has no curves."""
        a_map = kappa_map(machine, np.linspace(0.2, 0.4, 10), np.linspace(0.8, 1.0, 10), (0.0, 0.0), 0)
        assert singular_loops(a_map).shape == (0, 2)


class TestPayload:
    """Numbers on their way to the page."""

    def test_arrays_come_back(self) -> None:
        """Base64 text is the array in little-endian bytes, with its shape."""
        array = np.arange(6.0).reshape(2, 3)
        text = packed(array)
        assert text["shape"] == [2, 3]
        assert np.array_equal(np.frombuffer(base64.b64decode(text["base64"]), "<f4").reshape(2, 3), array)

    @given(st.lists(st.floats(10.0, 200.0), min_size=1, max_size=20))
    def test_levels_are_within_half_a_step(self, kappas: list[float]) -> None:
        """What a level stands for differs from kappa by at most half a step; beyond the cap it is the cap."""
        kappa = np.array(kappas)
        level = levels(kappa, 20.0, 100.0).astype(float)
        shown = 20.0 * 5.0 ** ((level - 1.0) / 254.0)
        assert np.all(np.abs(np.log(shown / np.clip(kappa, 20.0, 100.0))) <= 0.5001 * np.log(5.0) / 254.0)

    def test_out_of_reach_is_a_level_of_its_own(self) -> None:
        """What cannot be reached is distinguished from the least kappa."""
        assert levels(np.array([np.nan, 20.0]), 20.0, 100.0).tolist() == [OUT_OF_REACH, 1]

    def test_limits_that_are_none(self, report: Report) -> None:
        """An infinite limit becomes null, which JSON has."""
        free = replace(report, scene=replace(report.scene, qd_limits_mps=np.array([np.inf, 1.0, 1.0, 1.0, 1.0])))
        assert payload(free)["scene"]["qdLimits"] == [None, 1.0, 1.0, 1.0, 1.0]


class TestVerdicts:
    """What people look for first."""

    def test_a_certified_run(self, report: Report) -> None:
        """A complete and certified run is called so, and every verdict is good."""
        assert (report.headline.answer, report.headline.mood) == ("Certified", "good")
        answers = {verdict.topic: verdict for verdict in report.verdicts}
        assert answers["Run"].answer == "Exit code 0"
        assert answers["Certificate"].detail.startswith("1 boxes: κ at most 31.00")
        assert answers["Calibration"].answer == "±0.10 mm"
        assert answers["Route"].answer == "Optimal"
        assert answers["Limits"].mood == "good"

    def test_an_exceeded_limit_is_bad(self, complete: RunResults) -> None:
        """More than the limit is never called kept."""
        section = {**complete.facts[Stage.RETIME].section, "usage": {"velocity": [0.5, 1.01, 0.2, 0.1, 0.0]}}
        facts = {**complete.facts, Stage.RETIME: replace(complete.facts[Stage.RETIME], section=section)}
        limits = next(verdict for verdict in verdicts(facts) if verdict.topic == "Limits")
        assert (limits.answer, limits.mood) == ("Exceeded", "bad")
        assert "c2" in limits.detail

    def test_a_route_that_is_not_proven_optimal_is_no_good_news(self, complete: RunResults) -> None:
        """It is called what it is, with its gap."""
        section = {**complete.facts[Stage.ROUTE].section, "status": "not proven optimal", "gap": 0.073}
        facts = {**complete.facts, Stage.ROUTE: replace(complete.facts[Stage.ROUTE], section=section)}
        route = next(verdict for verdict in verdicts(facts) if verdict.topic == "Route")
        assert (route.answer, route.mood) == ("Not proven optimal", "open")
        assert route.detail.startswith("Gap 7.30 %")

    def test_limits_that_do_not_exist_are_left_out(self) -> None:
        """Only kinds with limits are shown, and of them the subject that uses most."""
        used = used_limits({"usage": {"velocity": [0.1, 0.2, 0.9, None, 0.3], "tcp_speed": "skipped"}})
        assert [(one.kind, one.subject, one.part) for one in used] == [("velocity", "c3", 0.9)]

    def test_a_run_that_stopped_early(self, complete: RunResults) -> None:
        """What has not been run is named."""
        facts = {stage: complete.facts[stage] for stage in (Stage.REGIONS, Stage.ROUTE)}
        assert headline(facts).detail.startswith("Refine ")


class TestTables:
    """Comparison and proof."""

    def test_the_proof_compares_all_samples(self, complete: RunResults, report: Report) -> None:
        """The least excess is of all samples, not only of those drawn, and those drawn hold the largest kappa."""
        assert report.proof is not None
        assert complete.samples is not None
        assert complete.profile is not None
        refined = complete.samples[1]
        proof = build_proof(complete.config, refined, complete.profile)
        bound = np.where(refined.s < 0.5, 30.0, 31.0)
        assert proof.least_excess == pytest.approx((bound / refined.kappa - 1.0).min())
        assert proof.kappa.max() == refined.kappa.max()
        assert (proof.edges[0], proof.edges[-1]) == (0.0, proof.length[-1])

    def test_the_comparison_has_durations(self, report: Report) -> None:
        """Both paths are timed alike, so that durations compare."""
        assert report.comparison is not None
        assert "duration" in [row[0] for row in report.comparison.rows]

    def test_a_coarse_path_that_cannot_be_driven(self, complete: RunResults) -> None:
        """The report says so, and the rest of it is there."""

        def refuse(*_: object) -> Trajectory:
            raise NoSolutionError("retime", "too heavy", "less load")

        report = build_report(replace(complete, coarse=None), refuse)
        assert [motion.name for motion in report.motions] == ["refined"]
        assert report.motion_note == "The coarse path is not shown in motion: too heavy."
        assert report.comparison is not None
        assert "duration" not in [row[0] for row in report.comparison.rows]

    def test_every_actuator_has_its_reversals_and_least_time(self, report: Report) -> None:
        """A row per actuator and one of all together, with what the summary states."""
        assert report.quality is not None
        assert [row[0] for row in report.quality.rows] == [*ACTUATORS, "all"]
        assert report.quality.rows[-1][2] == str(sum(int(row[2]) for row in report.quality.rows[:-1]))
        assert "times the minimum time of the slowest actuator moving alone" in report.quality.note

    def test_every_drive_has_its_masses_and_amplification(self, report: Report, complete: RunResults) -> None:
        """A row per drive, and the extremes of all with place and direction; without masses these are left out."""
        assert report.drives is not None
        assert [row[0] for row in report.drives.rows] == list(ACTUATORS)
        assert all(float(row[1]) <= float(row[2]) for row in report.drives.rows)
        assert "stiffness due to gravity is −" in report.drives.note
        section = complete.facts[Stage.RETIME].section["drives"]
        bare = drives_table({**section, "reflected_mass_kg": "skipped"})
        assert [row[1:3] for row in bare.rows] == [("−", "−")] * 5
        assert bare.note.startswith("No masses are given")

    def test_hashes_are_listed(self, report: Report) -> None:
        """The provenance has versions, the configuration's hash, and that of every file of a stage."""
        listed = dict(report.provenance)
        assert {"gantry-tau", "python", "configuration (SHA-256)"} <= set(listed)
        assert listed["route.npz"] == "route-hash"


def test_failures_keep_what_was_there(
    complete: RunResults, failed_at: Callable[[RunResults, Stage], RunResults]
) -> None:
    """A run that failed at the end still shows what was proven before."""
    report = build_report(failed_at(complete, Stage.RETIME))
    assert report.bounds is not None
    assert report.proof is not None
    assert report.usage == ()


def test_nearest_proven_distances_are_listed_and_the_others_counted(
    complete: RunResults, bodies_config: Config, bodies_machine: Machine
) -> None:
    """Twelve pairs with the least first, then how many more there are, with the least of theirs."""
    assert complete.bounds is not None
    assert bodies_machine.bodies is not None
    names = bodies_machine.bodies.names
    least = 0.01 + 0.001 * np.random.default_rng(1).permutation(len(names))
    proven = Ranges(names, np.column_stack([least, np.full(len(names), np.inf)]))
    table = distances_table(bodies_config, bodies_machine, replace(complete.bounds, ranges={"body_distance_m": proven}))
    *rows, others = table.rows
    nearest = [names[k] for k in np.argsort(least)]
    assert [row[0] for row in rows] == nearest[:12]
    assert [row[1] for row in rows] == [f"at least {0.01 + 0.001 * k:.5f} m" for k in range(12)]
    assert others == (f"{len(names) - 12} other pairs", "at least 0.02200 m", "at least 0.005 m")
