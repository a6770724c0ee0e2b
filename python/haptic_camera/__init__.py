"""How a mechanical knob feels, as numbers.

Captures are columns, models are lists of effects, and results are those of the command line ``haptic-camera``, key by key.
Units are those of the names: rad, rad/s, rad/s², mNm, s. Positive torque turns the knob towards positive angle.
"""

from haptic_camera._capture import capture, replay
from haptic_camera._native import (
    Capture,
    Diagnosis,
    Error,
    Figure,
    Fit,
    Judgement,
    Model,
    Parameter,
    Progress,
    Sheet,
    Verdict,
    diagnose,
    fit,
    judge,
    read,
    sheet,
    simulate,
    table_columns,
    table_row,
)

__all__ = [
    "Capture",
    "Diagnosis",
    "Error",
    "Figure",
    "Fit",
    "Judgement",
    "Model",
    "Parameter",
    "Progress",
    "Sheet",
    "Verdict",
    "capture",
    "diagnose",
    "fit",
    "judge",
    "read",
    "replay",
    "sheet",
    "simulate",
    "table_columns",
    "table_row",
]
