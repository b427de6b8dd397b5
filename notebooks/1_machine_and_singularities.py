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
# # The machine and its singularities
#
# Three carts on parallel rails carry a platform over six links; two of them are telescopes. Everything about a
# machine is in a YAML file, and nothing about it is in the code, so this is where we begin.

# %%
# %matplotlib inline
import numpy as np

from pipeline import (
    MODES,
    ForwardKinematicsError,
    build_machine,
    condition_number,
    forward_kinematics,
    inverse_kinematics,
    kappa_map,
    kappa_map_figure,
    load_config,
    postures_figure,
    statics_matrix,
)

config = load_config("../configs/quick.yaml")
machine = build_machine(config.machine)

# %% [markdown]
# ## One pose, eight working modes
#
# Each cart can stand to the left (L) or to the right (R) of its platform joint, so that one pose of the tool,
# here the start of the task, is reached in up to eight ways. Pictures first: the numbers below are about these.
# What turns is ry, the platform about the tool: the links of arm 3 dictate it, nobody commands it.

# %%
start = config.task.start
controlled = np.tile([start.x_m, start.y_m, start.z_m, 0.0, 0.0], (len(MODES), 1))  # x, y, z, rx, rz
stances = inverse_kinematics(machine, controlled, np.arange(len(MODES)))
postures_figure(machine, stances.pose, stances.q_m)

# %% [markdown]
# ## How firmly the links hold the platform
#
# The statics matrix H turns the forces along the six links into the force and the moment on the platform. Its
# condition number kappa says how unevenly it does: about 20 is good here; where it is infinite, det H = 0, the
# platform gives way in some direction. That is a Type-II singularity. Note RRL: det H has the other sign, so that
# on every way from LLL to there the machine has to be singular somewhere.

# %%
H = statics_matrix(machine, stances.pose, stances.q_m[:, :3])
for mode, pose, kappa, det in zip(MODES, stances.pose, condition_number(H), np.linalg.det(H), strict=True):
    print(f"{mode}   ry {np.rad2deg(pose[4]):+6.1f} degrees   kappa {kappa:6.1f}   det H {det:+.6f}")

# %% [markdown]
# ## Where it gives way
#
# One pose says little; the same numbers over the whole YZ plane show walls (x plays no role for kappa). All-left
# and all-right are free of singularities. The modes between them, through which every way from one to the other
# leads, are cut in two by them.

# %%
y_m, z_m = np.linspace(-0.4, 1.2, 161), np.linspace(0.3, 1.4, 111)
kappa_map_figure({mode: kappa_map(machine, y_m, z_m, (0.0, 0.0), number) for number, mode in enumerate(MODES)})

# %% [markdown]
# ## Tilting moves the walls
#
# This is what the whole program lives on: tilted about x, the same working mode has its singularities elsewhere,
# so that a path can wait in front of a wall, tilt, and go on behind it.

# %%
tilts = np.deg2rad([-20.0, -10.0, 10.0, 20.0])
kappa_map_figure(
    {f"LRL, rx {np.rad2deg(rx):+.0f}°": kappa_map(machine, y_m, z_m, (rx, 0.0), MODES.index("LRL")) for rx in tilts}
)

# %% [markdown]
# ## Why not simply drive the carts to the goal?
#
# The goal is the same pose, all-right. Let us drive all five actuators straight to the goal's positions and
# follow the pose, always from the one before. The pose needs a guess, since the same actuators may belong to
# several poses.

# %%
q_start, q_goal = stances.q_m[MODES.index("LLL")], stances.q_m[MODES.index("RRR")]
pose = stances.pose[MODES.index("LLL")]
try:
    for part in np.linspace(0.0, 1.0, 201):
        pose = forward_kinematics(machine, q_start + part * (q_goal - q_start), pose)[0]
except ForwardKinematicsError as error:
    print(error)
print(f"the carts are at the goal, the TCP is at x = {pose[0]:.2f} m instead of {start.x_m:.2f} m")

# %% [markdown]
# Every actuator is where the goal wants it, and the machine is still in LLL, far to the right: it is *assembled*
# differently. To change that, arms have to swing through, one after the other, where no wall is.

# %%
postures_figure(
    machine,
    np.stack([stances.pose[MODES.index("LLL")], pose, stances.pose[MODES.index("RRR")]]),
    np.stack([q_start, q_goal, q_goal]),
    titles=["start", "driven straight", "goal"],
)

# %% [markdown]
# Finding that way is what the [second notebook](2_route_to_trajectory.ipynb) does.
