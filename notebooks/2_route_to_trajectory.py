# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # From route to trajectory
#
# The stages of `gantry-tau run`, one by one. Each is a function of the configuration and of what the one before
# it made, and returns something that cannot change: so every result can be looked at, kept, and given to the next
# stage again. The quick configuration has a coarse grid; on the full one (`agder.yaml`) everything is the same
# and takes longer.

# %%
# %matplotlib inline
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from pipeline import (
    Format,
    MeasuredPath,
    Measurement,
    Reflectors,
    SimulationSetting,
    build_machine,
    build_regions,
    certify_path,
    compare_measurement,
    compare_paths,
    format_samples,
    kappa_figure,
    kappa_profile,
    load_config,
    load_path,
    machine_figure,
    measure_path,
    measured_figure,
    plan_route,
    pose_figure,
    proof_figure,
    refine_path,
    regions_figure,
    retime_path,
    route_figure,
    sample_path,
    sample_trajectory,
    save_path,
    simulate_measurement,
    step_sizes,
)

config = load_config("../configs/quick.yaml")
machine = build_machine(config.machine)

# %% [markdown]
# ## Regions: where the machine may be
#
# Poses on a grid, in all working modes, as far as they are in reach, firm and clear. Look at the gates: only
# there can an arm swing from left to right.

# %%
regions = build_regions(config, machine)
print(f"{len(regions):,} regions, {regions.gate_count:,} of them gates")
regions_figure(config, regions)

# %% [markdown]
# ## Route: the best sequence of regions
#
# The least integral of kappa along the moves, proven to be the least on this grid. Status and gap tell whether that
# proof is complete; look at them before anything else.

# %%
route = plan_route(config, machine, regions)
print(
    f"{route.status}: kappa integral {route.objective:.1f}, gap {route.search.gap:.0%}, largest {route.kappa_max:.1f}"
)
route_figure(config, machine, route)

# %% [markdown]
# The same route as the machine drives it: which arm swings when, and how far the platform tilts for it.

# %%
machine_figure(machine, route)

# %% [markdown]
# ## Path: smooth, and better than the grid
#
# A route has corners, and between its steps kappa may rise. Refining makes one smooth curve of it. To see what
# that buys, both are sampled alike: the picture has the integrals in its legend.

# %%
refinement = refine_path(config, machine, route)
s = np.linspace(0.0, 1.0, 2_001)
coarse, refined = sample_path(refinement.coarse, s), sample_path(refinement.path, s)
kappa_figure(config, route, coarse, refined)

# %% [markdown]
# The same in numbers, for a notebook of your own to decide on.

# %%
steps = step_sizes(config.route)
for row in compare_paths(*(MeasuredPath(measure_path(samples, steps)) for samples in (coarse, refined))):
    print(f"{row.figure:26} {row.coarse:10.4f} {row.refined:10.4f} {row.unit:5} {row.better}")

# %% [markdown]
# ## Certificate: between the samples, too
#
# Two thousand samples do not exclude a singularity between two of them. The certificate does: it is a proof over
# boxes that cover the whole path. Without the word "certified", stop here.

# %%
certificate = certify_path(config, machine, refinement.path)
print(certificate.verdict, "by", len(certificate.chain.boxes), "boxes")
proof_figure(config, refined, kappa_profile(machine, refinement.path, certificate.chain))

# %% [markdown]
# ## Trajectory: as fast as the limits allow
#
# Only now comes time in. Circles are the route's steps, dashed lines the instants at which an arm swings through.

# %%
trajectory = retime_path(config, refinement.path)
samples = sample_trajectory(trajectory, config.retime.period_s)
print(f"{trajectory.duration_s:.2f} s, {len(samples)} rows")
pose_figure(config, machine, route, coarse, samples)

# %% [markdown]
# ## Files
#
# A path can be kept and taken up again, and a trajectory goes to a controller in its own format. (A run folder
# with everything in it is `run_pipeline(config, folder)`; `open_results(folder)` gives the results of one.)

# %%
folder = Path(mkdtemp())
save_path(folder / "path.npz", refinement.path)
again = load_path(folder / "path.npz", machine)
assert np.array_equal(again.q(s), refinement.path.q(s))

message = format_samples(Format.ROS2, samples, machine.acceleration_mps2, config.export.joint_names)
(folder / "trajectory.yaml").write_text(message)
print(message[:300])

# %% [markdown]
# ## Does the real machine do that?
#
# A laser tracker that follows two reflectors on the platform tells. Here one is simulated, with a machine that is
# off by a fifth of a millimetre in every joint, to see beforehand what errors to expect; the band is the
# tracker's noise.

# %%
reflectors = Reflectors(np.array([[0.0, 0.10, 0.05], [0.0, 0.40, 0.05]]), noise_m=5e-5)
seen = simulate_measurement(machine, samples.q_m, samples.pose, reflectors, SimulationSetting(geometry_std_m=2e-4))
measured_figure(compare_measurement(Measurement(samples.t_s, seen, None), samples.pose, reflectors))
