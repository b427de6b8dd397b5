"""What a calibration lets expect: errors all over the workspace, and errors once more poses are measured."""
