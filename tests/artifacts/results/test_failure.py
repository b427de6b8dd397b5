"""Failures as files."""

import json

import numpy as np

from pipeline.artifacts.results.failure import failure_files
from pipeline.stage import Stage


def test_failures_are_kept_apart() -> None:
    """A diagnosis is kept under names no result has: numbers and words as JSON, arrays beside it."""
    diagnosis = {"pose": np.eye(2), "s": 0.5, "worst": np.inf, "odd": np.array([None])}
    files = failure_files(Stage.REFINE, {"reason": "why"}, diagnosis)
    assert list(files) == ["failed/refine.json", "failed/refine.npz"]
    told = json.loads(files["failed/refine.json"])
    assert told["reason"] == "why"
    assert told["diagnosis"] == {"s": 0.5, "worst": None, "odd": [None]}
    assert told["arrays"] == ["pose"]
    assert list(failure_files(Stage.REFINE, {}, {"s": 1})) == ["failed/refine.json"]
