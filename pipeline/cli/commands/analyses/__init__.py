"""Commands that compare, vary and bound: several runs, many tasks, the workspace."""
