from .controllers.beckhoff import (
    format_beckhoff as format_beckhoff,
)
from .controllers.beckhoff import (
    read_beckhoff as read_beckhoff,
)
from .controllers.linuxcnc import (
    format_halstreamer as format_halstreamer,
)
from .controllers.linuxcnc import (
    read_halstreamer as read_halstreamer,
)
from .controllers.ros2 import (
    format_json as format_json,
)
from .controllers.ros2 import (
    format_yaml as format_yaml,
)
from .controllers.ros2 import (
    read_joint_trajectory as read_joint_trajectory,
)
from .csv import (
    format_csv as format_csv,
)
from .csv import (
    read_csv as read_csv,
)
from .models.mjcf import (
    read_mjcf as read_mjcf,
)
from .motion import (
    Motion as Motion,
)
from .request import (
    CsvOptions as CsvOptions,
)
from .request import (
    ExportOptions as ExportOptions,
)
from .request import (
    ExportRequest as ExportRequest,
)
from .request import (
    needed_decimals as needed_decimals,
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
    export_files as export_files,
)
from .writing import (
    format_samples as format_samples,
)
from .writing import (
    read_motion as read_motion,
)
