"""Tables on the terminal."""

from collections.abc import Sequence

from soft_gripper.diagrams.schema.scenario import TaskConfig
from soft_gripper.evaluation.paper.pose_table import PoseRow
from soft_gripper.evaluation.phase_table import PhaseRow
from soft_gripper.evaluation.step_table import StepRow
from soft_gripper.evaluation.trials.trial import Judged
from soft_gripper.manipulation.task_phases import Outcome


def print_poses(rows: Sequence[PoseRow]) -> None:
    """A line for every held step of pressure."""
    print("\nfinger            pressure [kPa]   bend [degrees]   pose error [mm]   fingertip error [mm]")
    for row in rows:
        print(
            f"{row.finger:<17} {row.pressure_kpa:>14.1f} {row.bend_angle_deg:>16.2f}"
            f" {row.pose_error_mm:>17.3f} {row.tip_error_mm:>22.3f}"
        )


def print_steps(rows: Sequence[StepRow]) -> None:
    """A line for every step of the opening."""
    print("\nstep  from [mm]    to [mm]  overshoot [%]  settling [s]  steady error [mm]: estimated     true")
    for row in rows:
        print(
            f"{row.step:>4} {row.from_mm:>10.1f} {row.to_mm:>10.1f} {row.overshoot_percent:>14.2f}"
            f" {row.settling_s:>13.2f} {row.steady_error_estimated_mm:>29.4f} {row.steady_error_true_mm:>8.3f}"
        )


def print_truth(row: Judged) -> None:
    """What truly became of the object of a task."""
    print(
        f"In truth: {row.placed_error_mm:.1f} mm and {row.placed_angle_deg:.1f} degrees from the goal,"
        f" slip in the fingers {row.slip_mm:.1f} mm, normal force of a finger up to {row.peak_force_n:.2f} N"
    )


def print_phases(rows: Sequence[PhaseRow], outcome: Outcome, task: TaskConfig) -> None:
    """A line for every phase of a task, and how it ended."""
    print("\nphase           began [s]  lasted [s]  at its end:  opening [mm]  torque [mN m]  pressure [kPa]")
    for row in rows:
        print(
            f"{row.phase:<15} {row.began_s:>9.2f} {row.lasted_s:>11.2f} {row.opening_mm:>26.1f}"
            f" {row.torque_mnm:>14.1f} {row.pressure_kpa:>15.1f}"
        )
    late = f", not over after {task.time_limit:g} s (task.time_limit)" if outcome == Outcome.RUNNING else ""
    print(f"\nOutcome, as estimated: {outcome.words}{late}")
