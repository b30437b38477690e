"""Tables on the terminal."""

from collections.abc import Sequence

from soft_gripper.evaluation.pose_table import PoseRow
from soft_gripper.evaluation.step_table import StepRow


def print_poses(rows: Sequence[PoseRow]) -> None:
    """A line for every held step of pressure."""
    print("\nfinger            pressure [kPa]   bend [degrees]   pose error [mm]   fingertip error [mm]")
    for row in rows:
        print(
            f"{row.finger:<17} {row.pressure_kpa:>14.1f} {row.bend_angle_deg:>16.2f}"
            f" {row.pose_error_mm:>17.3f} {row.tip_error_mm:>22.3f}"
        )


def print_steps(rows: Sequence[StepRow]) -> None:
    """A line for every step of the fingertip distance."""
    print("\nstep  from [mm]    to [mm]  overshoot [%]  settling [s]  steady error [mm]: estimated     true")
    for row in rows:
        print(
            f"{row.step:>4} {row.from_mm:>10.1f} {row.to_mm:>10.1f} {row.overshoot_percent:>14.2f}"
            f" {row.settling_s:>13.2f} {row.steady_error_estimated_mm:>29.4f} {row.steady_error_true_mm:>8.3f}"
        )
