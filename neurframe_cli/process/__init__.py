"""Child processes: one way to run them, limit them, watch them and name what went wrong."""

from neurframe_cli.process.run_child import ChildResult, run_child

__all__ = ["ChildResult", "run_child"]
