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
# # From tracker to calibrated path
#
# No machine is what its drawing says. A laser tracker that sees two reflectors on the platform tells what it is
# instead: here from simulated measurements, so that the truth is known in the end. On the command line the same is
# `gantry-tau calibrate`.

# %%
# %matplotlib inline
from pathlib import Path

import numpy as np

from pipeline import (
    build_machine,
    build_regions,
    certify_path,
    load_config,
    plan_route,
    refine_path,
    sample_path,
)
from pipeline.calibrate import (
    Setting,
    StaticSetting,
    calibrate,
    calibrated_yaml,
    first_poses,
    judge,
    next_poses,
    simulate_static,
)
from pipeline.calibrate.model.forward import close, positions
from pipeline.calibrate.predict.learning import learning_curves
from pipeline.calibrate.predict.maps import error_maps
from pipeline.config.file import parse_config
from pipeline.figures.calibration import (
    error_maps_figure,
    learning_figure,
    parameters_figure,
    residuals_figure,
    singular_values_figure,
)
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.measured.reflectors import reflector_positions
from pipeline.yaml_text import parse_yaml

file = Path("../configs/tiny.yaml")
config = load_config(file)
reflectors_m = np.array([[0.0, 0.10, 0.05], [0.0, 0.40, 0.05]])

# %% [markdown]
# ## A machine that is not as configured
#
# Every joint, rail and length is off by 0.2 mm or so, encoders have wrong zeros and scales, and the tracker stands
# anywhere. Nothing below looks at that machine but through the tracker.

# %%
real = simulate_static(config, reflectors_m, StaticSetting(geometry_std_m=2e-4, scale_std=1e-4, noise_m=5e-5, seed=5))

# %% [markdown]
# ## A dozen moderate poses
#
# Nothing is known yet, so the first poses keep away from singularities, where a machine that is off may not even
# assemble. They are chosen so that each tells what those before did not.

# %%
first = first_poses(config, reflectors_m, Setting(), 12)
measured = real.measure(first.q_m, first.pose)
rough = calibrate(config, reflectors_m, measured, Setting())
print("accepted" if judge(rough).accepted else judge(rough).reasons)
print(f"configured {1e3 * rough.fitted.before_m:.2f} mm off, calibrated {1e3 * rough.fitted.after_m:.3f} mm")

# %% [markdown]
# Small residuals at a few poses prove little: 12 poses have few more coordinates than the machine has parameters. What
# counts is which directions of the parameters the data tell. The rest is what was known beforehand, and the gauges are
# what no tracker can ever see.

# %%
singular_values_figure(rough, judge(rough))

# %% [markdown]
# ## Which poses next
#
# The covariance says where it is worth to measure. Chosen poses are worth twice as many at random.

# %%
learning_figure(learning_curves(rough, further=24))

# %% [markdown]
# So two dozen more of these are measured, now also nearer to singularities. (`gantry-tau tour` drives there: a
# certified motion from pose to pose.)

# %%
more = next_poses(rough, 24)
measured = measured.joined(real.measure(more.q_m, more.pose))
calibration = calibrate(config, reflectors_m, measured, Setting())
print("accepted" if judge(calibration).accepted else judge(calibration).reasons)
residuals_figure(calibration)

# %% [markdown]
# ## The machine as it is
#
# Most numbers moved by far more than they are uncertain now. Open marks are where the data say little: rail, cart zero
# and cart joint share what only their sum tells, and that sum is well known.

# %%
parameters_figure(calibration)

# %% [markdown]
# What matters is where the platform is. Above, how far the machine as configured is off; below, what is left.

# %%
error_maps_figure(error_maps(calibration))

# %% [markdown]
# ## Plan with it
#
# The calibrated machine is a configuration like any other: the file with its comments, and other numbers.

# %%
text = calibrated_yaml(file.read_text(), config, calibration.identification.model, "Calibrated.")
calibrated = parse_config(parse_yaml(text), default_name="calibrated")

# %% [markdown]
# Both machines plan the same task, and the real one drives both paths, by what its encoders show. How far are the
# reflectors from where each plan has them? The tracker's frame and the reflectors are those that were found.

# %%
found = calibration.identification.model
for name, used in (("configured", config), ("calibrated", calibrated)):
    machine = build_machine(used.machine)
    path = refine_path(used, machine, plan_route(used, machine, build_regions(used, machine))).path
    verdict, samples = certify_path(used, machine, path).verdict, sample_path(path, np.linspace(0.0, 1.0, 201))
    q_m, pose = controller_units(used.machine).to_controller(samples.q_m), samples.pose
    planned_m = reflector_positions(found.reflectors_m, pose) @ found.rotation.T + found.translation_m
    driven_m = positions(real.truth, close(real.truth, q_m, pose))
    off_m = np.linalg.norm(driven_m - planned_m, axis=2)
    print(f"{name}, {verdict}: {1e3 * np.sqrt((off_m**2).mean()):.3f} mm rms, {1e3 * off_m.max():.3f} mm at most")
