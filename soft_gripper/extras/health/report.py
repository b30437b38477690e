"""Lines of `soft-gripper run` on the health of fingers."""

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.calibration_range import FAR
from soft_gripper.extras.health.faults import FAULTS


def named_faults(station: Station, recording: Recording) -> list[str]:
    """Lines on fingers with a fault named at the end, its beginning, and readings far from a calibration."""
    lines = []
    for finger in station.fingers:
        name = f"{finger.name}.fault"
        if name in recording.data and (fault := int(recording[name].values[-1])):
            probability = recording[f"{finger.name}.fault_probabilities"].values[-1, fault]
            onset_time = recording["time"].values[recording[name].values.ravel() == 0].max(initial=0.0)
            lines.append(f"{finger.name}: {FAULTS[fault]} ({probability:.0%}), since {onset_time:.2f} s")
        if name in recording.data and f"{finger.name}.{FAR}" in recording.data:
            share = float(recording[f"{finger.name}.{FAR}"].values.mean())
            if share:
                lines.append(f"{finger.name}: {share:.0%} of the run is far from its calibration, where less is known")
    return lines
