"""soft-gripper evaluate: the paper's evaluation."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from soft_gripper.commands.options import Subparsers
from soft_gripper.commands.progress import progress_bar
from soft_gripper.diagrams.scenario_file import load_scenario
from soft_gripper.evaluation.claims import Claim
from soft_gripper.evaluation.evaluate import SECTIONS, evaluate
from soft_gripper.evaluation.pose_table import PoseRow, mean

from soft_gripper.files import writable_folder


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = subparsers.add_parser("evaluate", help="run the paper's evaluation with 1 to 4 sensors a side")
    parser.add_argument(
        "--out", metavar="DIR", type=Path, default=Path("results/evaluation"), help="default: %(default)s"
    )
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    out = writable_folder(options.out)
    with progress_bar("free_bending", load_scenario("free_bending").duration) as progress:
        rows, claims = evaluate(out, progress)
    _print_errors(rows)
    _print_claims(claims)
    print(f"\nWritten to {out}: metrics.csv, free_bending.nc, fig5_free_bending.png and .svg")


def _print_errors(rows: Sequence[PoseRow]) -> None:
    print("\nFree bending   pose error [mm]    fingertip error [mm]")
    print("sensors        mean   largest      mean   largest")
    for sections in SECTIONS:
        pose, tip = (
            [getattr(r, e) for r in rows if r.sections == sections] for e in ("pose_error_mm", "tip_error_mm")
        )
        print(f"{sections:>7} {mean(pose):>11.3f} {max(pose):>9.3f} {mean(tip):>9.3f} {max(tip):>9.3f}")


def _print_claims(claims: Sequence[Claim]) -> None:
    print("\nClaim                                                           by      here")
    for claim in claims:
        verdict = "holds" if claim.holds else "FAILS"
        print(f"{claim.text:<63} {claim.source:<7} {verdict}: {claim.number}")
