# The public interface of the package, and its only list: what is imported here can be imported from `pipeline`.

# Configuration, and what can be wrong
from .config import (
    Config as Config,
)
from .config.file import (
    load_config as load_config,
    parse_config as parse_config,
    dump_config as dump_config,
)
from .errors import (
    PipelineError as PipelineError,
    ConfigError as ConfigError,
    UsageError as UsageError,
    ArgumentError as ArgumentError,
    NoSolutionError as NoSolutionError,
    InfeasibleError as InfeasibleError,
    ForwardKinematicsError as ForwardKinematicsError,
)

# The machine at poses
from .machine import (
    MODES as MODES,
    Machine as Machine,
    build_machine as build_machine,
    InverseSolution as InverseSolution,
    inverse_kinematics as inverse_kinematics,
    forward_kinematics as forward_kinematics,
    statics_matrix as statics_matrix,
    condition_number as condition_number,
    det_sign as det_sign,
    link_distances as link_distances,
    min_distances as min_distances,
)

# The stages, in their order, and what they make
from .route import (
    RegionTable as RegionTable,
    build_regions as build_regions,
    Route as Route,
    plan_route as plan_route,
    plan_routes as plan_routes,
)
from .refine import (
    Path as Path,
    Refinement as Refinement,
    refine_path as refine_path,
)
from .certify import (
    Certificate as Certificate,
    certify_path as certify_path,
    Uncertainty as Uncertainty,
)
from .pose_error import (
    PoseError as PoseError,
    SampledError as SampledError,
    bound_pose_error as bound_pose_error,
    sample_pose_error as sample_pose_error,
)
from .retime import (
    Trajectory as Trajectory,
    retime_path as retime_path,
    way_back as way_back,
    slowed as slowed,
)

# Along a path, and over time
from .refine import (
    PathSamples as PathSamples,
    sample_path as sample_path,
    PathFigures as PathFigures,
    measure_path as measure_path,
    kappa_along as kappa_along,
    pose_derivatives as pose_derivatives,
    pose_spline as pose_spline,
)
from .certify.recheck import (
    KappaProfile as KappaProfile,
    kappa_profile as kappa_profile,
)
from .retime import (
    TrajectorySamples as TrajectorySamples,
    sample_trajectory as sample_trajectory,
    TrajectoryFigures as TrajectoryFigures,
    measure_trajectory as measure_trajectory,
)

# Runs, and files
from .stage import (
    Stage as Stage,
)
from .run import (
    Results as Results,
    RunOptions as RunOptions,
    RunReport as RunReport,
    run_pipeline as run_pipeline,
    open_results as open_results,
)
from .artifacts.results.path import (
    load_path as load_path,
    save_path as save_path,
)
from .export.formats import (
    Format as Format,
)
from .export import (
    CsvOptions as CsvOptions,
    ExportOptions as ExportOptions,
    ExportRequest as ExportRequest,
    export_files as export_files,
    format_samples as format_samples,
)

# Routes and motions between many stations
from .atlas import (
    AtlasRecord as AtlasRecord,
    MotionRecord as MotionRecord,
    PairRecord as PairRecord,
    StationRecord as StationRecord,
)
from .run.atlas import (
    AtlasOptions as AtlasOptions,
    make_atlas as make_atlas,
)
from .artifacts.atlas_record import (
    read_atlas as read_atlas,
)

# Comparisons
from .route.metric import (
    step_sizes as step_sizes,
)
from .compare import (
    MeasuredPath as MeasuredPath,
    MotionFigures as MotionFigures,
    measure_motion as measure_motion,
    blended as blended,
    ComparisonRow as ComparisonRow,
    compare_paths as compare_paths,
    markdown_table as markdown_table,
    RunsRow as RunsRow,
    compare_runs as compare_runs,
    runs_markdown as runs_markdown,
)

# The usable workspace
from .workspace import (
    WorkspaceSetting as WorkspaceSetting,
    Workspace as Workspace,
    usable_workspace as usable_workspace,
    WorkspaceRow as WorkspaceRow,
    workspace_rows as workspace_rows,
    Installation as Installation,
    SpaceUse as SpaceUse,
    measure_space as measure_space,
)

# Measured motions
from .measured import (
    Reflectors as Reflectors,
    Measurement as Measurement,
    parse_measurement as parse_measurement,
    read_measurement as read_measurement,
    MeasurementComparison as MeasurementComparison,
    compare_measurement as compare_measurement,
    ErrorRow as ErrorRow,
    error_rows as error_rows,
    SimulationSetting as SimulationSetting,
    simulate_measurement as simulate_measurement,
)

# The machine with its drives, simulated
from .simulate import (
    Drives as Drives,
    build_drives as build_drives,
    Deviations as Deviations,
    Plant as Plant,
    build_plant as build_plant,
    Motion as Motion,
    plan_motion as plan_motion,
    Simulation as Simulation,
    simulate_motion as simulate_motion,
)
from .simulate.tuning import (
    Tuning as Tuning,
    tune_drives as tune_drives,
)

# Pictures, as matplotlib figures
from .figures.maps.kappa_map import (
    KappaMap as KappaMap,
    kappa_map as kappa_map,
)
from .figures import (
    RunData as RunData,
    all_figures as all_figures,
    bodies_figure as bodies_figure,
    clearance_figure as clearance_figure,
    drives_figure as drives_figure,
    kappa_figure as kappa_figure,
    kappa_map_figure as kappa_map_figure,
    loads_figure as loads_figure,
    machine_figure as machine_figure,
    measured_figure as measured_figure,
    phase_figure as phase_figure,
    pose_error_figure as pose_error_figure,
    pose_figure as pose_figure,
    postures_figure as postures_figure,
    proof_figure as proof_figure,
    regions_figure as regions_figure,
    route_figure as route_figure,
    trajectory_figure as trajectory_figure,
    usage_figure as usage_figure,
    workspace_figure as workspace_figure,
    workspace_volume_figure as workspace_volume_figure,
)
