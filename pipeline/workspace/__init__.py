"""The usable workspace of a machine, in each working mode and in all of them together."""

from pipeline.workspace.installation import Installation, SpaceUse, measure_space
from pipeline.workspace.table import WorkspaceRow, workspace_rows
from pipeline.workspace.usable import Workspace, WorkspaceSetting, usable_workspace

__all__ = [
    "Installation",
    "SpaceUse",
    "Workspace",
    "WorkspaceRow",
    "WorkspaceSetting",
    "measure_space",
    "usable_workspace",
    "workspace_rows",
]
