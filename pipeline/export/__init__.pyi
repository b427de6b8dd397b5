from .beckhoff import (
    format_beckhoff as format_beckhoff,
    read_beckhoff as read_beckhoff,
)
from .csv import (
    format_csv as format_csv,
    read_csv as read_csv,
    trajectory_columns as trajectory_columns,
)
from .linuxcnc import (
    format_halstreamer as format_halstreamer,
    read_halstreamer as read_halstreamer,
)
from .motion import (
    Motion as Motion,
    motion_of as motion_of,
    needed_decimals as needed_decimals,
)
from .mujoco import (
    format_keyframes as format_keyframes,
    read_keyframes as read_keyframes,
)
from .ros2 import (
    format_json as format_json,
    format_yaml as format_yaml,
    read_joint_trajectory as read_joint_trajectory,
)
from .sidecar import (
    sidecar as sidecar,
)
from .writing import (
    CsvOptions as CsvOptions,
    format_samples as format_samples,
)
