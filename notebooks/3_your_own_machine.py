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
# # Try out a geometry
#
# What to check, and in which order, before a new machine is worth a fine grid. The example is wider and longer
# than the reference machine. Nothing here takes more than seconds, so that geometries can be tried out.

# %%
# %matplotlib inline
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from pipeline import (
    MODES,
    ConfigError,
    NoSolutionError,
    WorkspaceSetting,
    build_machine,
    build_regions,
    condition_number,
    dump_config,
    inverse_kinematics,
    load_config,
    machine_figure,
    min_distances,
    parse_config,
    plan_route,
    postures_figure,
    statics_matrix,
    usable_workspace,
    workspace_volume_figure,
)

# %% [markdown]
# ## Describe it
#
# Begin with a configuration that works and change what is different: as a dictionary here, in a copy of the YAML
# file otherwise. Keys are the same.

# %%
data = load_config("../configs/quick.yaml").model_dump(mode="json")
data["name"] = "wide"
rails, links = data["machine"]["rails"], data["machine"]["links"]
rails[1]["y_m"] = 0.9
for rail in rails:
    rail["travel_m"] = [0.0, 2.4]
for name in ("l1", "l2a"):
    links[name]["length_m"] = 1.15
links["l2b"]["stroke_m"] = [1.01, 1.31]

# %% [markdown]
# ## Let it be refused
#
# Every key is checked. A message names the key, what it found and what is allowed; read it as a list of what to
# do. Here a telescope's stroke is the wrong way round.

# %%
wrong = {**data, "machine": {**data["machine"], "links": {**links, "l2b": {**links["l2b"], "stroke_m": [1.31, 1.01]}}}}
try:
    parse_config(wrong)
except ConfigError as error:
    print(error)

# %% [markdown]
# ## Compare it with the drawing
#
# Before anything is planned: is the machine at the start and at the goal as it was meant? If the platform is
# turned by half a turn, `triangle_branch` is the other one. Carts have to be on their rails, kappa far below 100,
# links apart.

# %%
for end in ("start", "goal"):
    data["task"][end]["x_m"] = 1.2  # the middle of the longer rails
config = parse_config(data)
machine = build_machine(config.machine)
ends = [config.task.start, config.task.goal]
stances = inverse_kinematics(
    machine,
    np.array([[end.x_m, end.y_m, end.z_m, np.deg2rad(end.rx_deg), np.deg2rad(end.rz_deg)] for end in ends]),
    np.array([MODES.index(end.mode) for end in ends]),
)
kappa = condition_number(statics_matrix(machine, stances.pose, stances.q_m[:, :3]))
apart_m, _ = min_distances(machine, stances.pose, stances.q_m[:, :3])
for name, q_m, value, distance_m in zip(("start", "goal"), stances.q_m, kappa, apart_m, strict=True):
    print(f"{name:5}  carts and telescopes {q_m.round(3)} m  kappa {value:.1f}  links {distance_m:.3f} m apart")
postures_figure(machine, stances.pose, stances.q_m)

# %% [markdown]
# ## Is it worth it?
#
# Changing the working mode pays if all modes together reach much more than the best one alone. A coarse step is
# enough to compare geometries by.

# %%
workspace = usable_workspace(machine, WorkspaceSetting(step_m=0.01))
print(f"all modes together reach {workspace.union_m3 / workspace.volumes_m3.max():.2f} times as much as the best one")
workspace_volume_figure(machine, workspace)

# %% [markdown]
# ## Is there a way?
#
# On a grid this coarse that takes seconds. A proof that there is none would be one for this grid only.

# %%
regions = build_regions(config, machine)
route = plan_route(config, machine, regions)
print(f"{route.status}: {' '.join(dict.fromkeys(route.mode_names))}, largest kappa {route.kappa_max:.1f}")
machine_figure(machine, route)

# %% [markdown]
# ## And if there is none?
#
# Then the error has the reason and what restricts it. Without tilt, for one, this machine cannot do it either. (On
# the command line `gantry-tau route` also finds out by how much each limit would have to give.)

# %%
upright = parse_config({**data, "task": {**data["task"], "tilt_max_deg": 0.0}})
try:
    plan_route(upright, machine, build_regions(upright, machine))
except NoSolutionError as error:
    print(error)

# %% [markdown]
# ## Go on
#
# Write the configuration as a file, make the grid finer, and run everything: `gantry-tau run wide.yaml`. The
# [second notebook](2_route_to_trajectory.ipynb) does the rest from Python.

# %%
file = Path(mkdtemp()) / "wide.yaml"
file.write_text(dump_config(config))
assert load_config(file) == config
