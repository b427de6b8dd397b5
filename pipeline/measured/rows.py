"""Errors of measurements that say which row is the reason."""

from pipeline.errors import UsageError


class RowError(UsageError):
    """A measurement cannot be used because of a row, whose index is `row`; `message` is the text without it."""

    def __init__(self, message: str, row: int) -> None:
        super().__init__(message, row)
        self.message = message
        self.row = row

    def __str__(self) -> str:
        return f"index {self.row}: {self.message}"
