"""The usable workspace of a machine, in each working mode and in all of them together."""

from pipeline.workspace.table import WorkspaceRow, workspace_rows
from pipeline.workspace.usable import Workspace, WorkspaceSetting, usable_workspace

__all__ = ["Workspace", "WorkspaceRow", "WorkspaceSetting", "usable_workspace", "workspace_rows"]
