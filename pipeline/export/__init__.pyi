from .beckhoff import (
    format_beckhoff as format_beckhoff,
)
from .beckhoff import (
    read_beckhoff as read_beckhoff,
)
from .csv import (
    format_csv as format_csv,
)
from .csv import (
    read_csv as read_csv,
)
from .linuxcnc import (
    format_halstreamer as format_halstreamer,
)
from .linuxcnc import (
    read_halstreamer as read_halstreamer,
)
from .motion import (
    Motion as Motion,
)
from .mujoco import (
    format_keyframes as format_keyframes,
)
from .mujoco import (
    read_keyframes as read_keyframes,
)
from .request import (
    CsvOptions as CsvOptions,
)
from .request import (
    ExportRequest as ExportRequest,
)
from .request import (
    needed_decimals as needed_decimals,
)
from .ros2 import (
    format_json as format_json,
)
from .ros2 import (
    format_yaml as format_yaml,
)
from .ros2 import (
    read_joint_trajectory as read_joint_trajectory,
)
from .sidecar import (
    sidecar as sidecar,
)
from .trajectory_columns import (
    TRAJECTORY_COLUMNS as TRAJECTORY_COLUMNS,
)
from .trajectory_columns import (
    TrajectoryColumn as TrajectoryColumn,
)
from .trajectory_columns import (
    trajectory_columns as trajectory_columns,
)
from .trajectory_csv import (
    format_trajectory_csv as format_trajectory_csv,
)
from .trajectory_csv import (
    read_trajectory_csv as read_trajectory_csv,
)
from .writing import (
    format_samples as format_samples,
)
from .writing import (
    read_motion as read_motion,
)
