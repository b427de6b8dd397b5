"""Limited jerk: known shortest times of lines, every limit at every instant, rest without acceleration at both ends."""

import signal
from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.machine import Machine
from pipeline.progress import Monitor
from pipeline.refine.result import Path
from pipeline.retime import measure_usage
from pipeline.retime.fastest import plan
from pipeline.retime.jerk.first_guess import first_guess
from pipeline.retime.jerk.options import DEFAULTS, JerkOptions
from pipeline.retime.jerk.program import Checks, build_program, solve_program
from pipeline.retime.jerk.solve import JerkLimited, limit_jerk
from pipeline.retime.path_dynamics import grid, tabulate_dynamics
from pipeline.retime.quantities import evaluate


def _limited(path: Path, pieces: int = 150, options: JerkOptions = DEFAULTS) -> JerkLimited:
    return limit_jerk(tabulate_dynamics(path, grid(1_001)), plan(path, 1_000), pieces, options=options)


@pytest.fixture(scope="module")
def found(path: Path) -> JerkLimited:
    """The curve, driven with limited jerk."""
    return _limited(path, 250)


def _shortest(travel_m: float, v: float, a: float, j: float) -> float:
    """The seven-segment profile in closed form: which of velocity and acceleration limits are reached decides."""
    if travel_m >= v * (v / a + a / j):
        return travel_m / v + v / a + a / j
    if travel_m >= 2.0 * a**3 / j**2:
        return a / j + np.sqrt((a / j) ** 2 + 4.0 * travel_m / a)
    return 4.0 * float(np.cbrt(travel_m / (2.0 * j)))


@pytest.mark.parametrize("travel_m", [0.9, 0.3, 0.1, 0.01, 1e-4])
def test_a_straight_line_takes_its_seven_segments(line, machine: Machine, travel_m: float) -> None:
    """Within a thousandth of the closed form; never below it, but for what between-sample excess allows."""
    expected = _shortest(travel_m, 0.5, 2.0, 40.0)
    taken = _limited(line(travel_m)).trajectory.motion_s
    assert taken == pytest.approx(expected, rel=1.5e-3)
    assert taken >= expected * (1.0 - 3e-4)


def test_all_limits_hold_everywhere(found: JerkLimited) -> None:
    """Jerk included; nothing is exceeded by more than what time is stretched for afterwards."""
    usage = measure_usage(found.trajectory, 0.01)
    assert usage.jerk_held
    assert usage.largest <= 1.001
    assert min(usage.fractions["velocity"].max(), usage.fractions["jerk"].max()) > 0.99


def test_it_starts_and_ends_without_acceleration(found: JerkLimited) -> None:
    """Velocity, acceleration and jerk are zero at both ends, and accelerations do not jump anywhere."""
    law = found.trajectory.time_law
    for order in (1, 2, 3):
        assert law(0.0, nu=order) == pytest.approx(0.0, abs=1e-9)
        assert law(law.x[-1], nu=order) == pytest.approx(0.0, abs=1e-4)
    inner, before = law.x[1:-1], law.x[1:-1] - 1e-12
    for order, size in ((0, 1e-10), (1, 1e-8), (2, 1e-6), (3, 1e-4)):
        scale = np.abs(law(law.x, nu=order)).max()
        assert law(before, nu=order) == pytest.approx(law(inner, nu=order), abs=size * scale)


def test_it_takes_longer_than_without(found: JerkLimited, path: Path) -> None:
    """Limiting jerk costs time, here a percent, and less the more jerk is allowed."""
    fastest = plan(path, 2_000).duration_s
    assert 1.0 < found.trajectory.motion_s / fastest < 1.02
    eager = _limited(replace(path, machine=replace(path.machine, jerk_mps3=4.0 * path.machine.jerk_mps3)))
    assert fastest * 0.999 < eager.trajectory.motion_s < found.trajectory.motion_s


def test_the_way_back_takes_as_long(found: JerkLimited, reversed_path: Path) -> None:
    """Limits are symmetric: another program, begun at the other end, comes to the same duration."""
    assert _limited(reversed_path, 250).trajectory.motion_s == pytest.approx(found.trajectory.motion_s, rel=1e-3)


@pytest.mark.parametrize("k", [0.2, 5.0])
def test_another_clock_gives_the_same_motion(path: Path, k: float) -> None:
    """Velocities times k, accelerations times k^2, jerks times k^3 shorten the time by k."""
    machine = replace(path.machine, masses=None)
    faster = replace(
        machine,
        velocity_mps=machine.velocity_mps * k,
        acceleration_mps2=machine.acceleration_mps2 * k**2,
        jerk_mps3=machine.jerk_mps3 * k**3,
    )
    one, other = (_limited(replace(path, machine=used)).trajectory.motion_s for used in (machine, faster))
    assert other * k == pytest.approx(one, rel=1e-3)


def test_tcp_and_forces_are_limited_too(path: Path) -> None:
    """Tight limits on the TCP, a drive and the links are used up and kept, and cost time."""
    tight = replace(
        path.machine,
        tcp_speed_mps=0.25,
        tcp_acceleration_mps2=0.5,
        force_n=np.array([180.0, 400.0, 400.0, 1_000.0, 1_000.0]),
    )
    limited = _limited(replace(path, machine=tight), 200)
    usage = measure_usage(limited.trajectory, 0.01)
    assert usage.largest <= 1.001
    assert usage.fractions["tcp_speed"].max() > 0.99
    assert usage.fractions["tcp_acceleration"].max() > 0.95
    assert limited.trajectory.motion_s > _limited(path).trajectory.motion_s


def test_actuators_without_a_jerk_limit_are_left_alone(path: Path) -> None:
    """Limits of the carts alone: telescopes exceed what theirs would have been."""
    jerk = path.machine.jerk_mps3.copy()
    jerk[3:] = np.inf
    usage = measure_usage(_limited(replace(path, machine=replace(path.machine, jerk_mps3=jerk))).trajectory)
    assert usage.largest <= 1.001
    assert np.all(usage.fractions["jerk"][3:] == 0.0)
    assert usage.peaks["jerk"][3:].max() > 10.0


def test_more_pieces_come_nearer_to_the_shortest_time(line) -> None:
    """The excess over the closed form falls as pieces get smaller."""
    expected = _shortest(0.3, 0.5, 2.0, 40.0)
    excess = [_limited(line(0.3), pieces).trajectory.motion_s / expected - 1.0 for pieces in (40, 320)]
    assert excess[1] < excess[0]
    assert excess[1] < 1e-3


def test_a_program_that_is_not_solved_is_an_error(path: Path) -> None:
    """When the solver gives up, it says so, with what to change."""
    with pytest.raises(NoSolutionError, match=r"did not converge \(maximum iterations exceeded") as caught:
        _limited(path, options=JerkOptions(iterations=2))
    assert "retime.jerk" in caught.value.advice


@pytest.mark.parametrize("limit", ["TCP speed", "acceleration"])
def test_slow_motions_are_found_though_their_ramps_are_short(path: Path, limit: str) -> None:
    """Minutes of motion with changes of acceleration within a fraction of a second, or of a millisecond."""
    machine = replace(path.machine, masses=None)
    if limit == "TCP speed":
        slow = replace(machine, tcp_speed_mps=0.01)
    else:
        slow = replace(machine, acceleration_mps2=1e-3 * machine.acceleration_mps2)
    slow_path = replace(path, machine=slow)
    law = _limited(slow_path, 100).trajectory
    assert measure_usage(law).largest <= 1.01
    assert law.motion_s == pytest.approx(plan(slow_path, 4_000).duration_s, rel=0.01)


def test_a_guess_that_fails_is_slowed_down(path: Path) -> None:
    """With too few pieces at the switches the program is not solved from the first guess; twice as slow, it is."""
    options = JerkOptions(pieces_per_width=0.0, rounds=1, most_ramps=1e9)
    slow = replace(path, machine=replace(path.machine, tcp_speed_mps=0.01, masses=None))
    table, fastest = tabulate_dynamics(slow, grid(1_001)), plan(slow, 1_000)
    found = limit_jerk(table, fastest, 300, options=options)
    assert found.trajectory.motion_s < 1.2 * fastest.duration_s
    with pytest.raises(NoSolutionError, match="did not converge"):
        limit_jerk(table, fastest, 300, options=replace(options, slowdowns=(1.0,)))


def test_an_interrupt_is_no_failed_solve(path: Path) -> None:
    """Ctrl-C in the middle of a program ends the stage as what it is."""

    def interrupt(message: str, fraction: float | None = None) -> None:
        if message.endswith("IPOPT iteration 3"):
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        limit_jerk(tabulate_dynamics(path, grid(1_001)), plan(path, 500), 80, Monitor(interrupt))


def test_the_program_keeps_limits_where_it_checks_them(path: Path) -> None:
    """At breakpoints and at checks within pieces; and its law goes through all breakpoints."""
    table = tabulate_dynamics(path, grid(1_001))
    guess = first_guess(table, plan(path, 500), 80)
    checks = Checks(np.arange(len(guess.h)), np.full(len(guess.h), 0.5))
    law = guess
    for _ in range(3):
        law, status, _ = solve_program(build_program(table, law, checks), 300)
        assert status == "Solve_Succeeded"
    time_law = law.time_law()
    assert time_law(time_law.x[1:] - 1e-13) == pytest.approx(law.s[1:], abs=1e-8)
    machine = path.machine
    for s, *state in (law.state(checks.piece, 0.0), law.state(checks.piece, 0.5)):
        values = evaluate(table.at(s), *state)
        assert (np.abs(values["jerk"]) / machine.jerk_mps3).max() <= 1.0 + 1e-3
        assert (np.abs(values["acceleration"]) / machine.acceleration_mps2).max() <= 1.0 + 1e-3
