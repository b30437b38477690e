"""soft-gripper expand: a URDF with <finger>s -> plain URDF."""

import argparse
import sys
from collections.abc import Iterator

from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file, check_file
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.scenario.model_files import model_path


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    expanded = expand_urdf(model_path(options.file), options.segments)
    if not expanded.fingers:
        raise InputError(options.file, "finger", None, "there is no <finger> in the file to expand")
    for finger in expanded.fingers:
        for note in _left_out(finger):
            print(f"note: '{finger.name}': {note}", file=sys.stderr)
    if options.out is None:
        print(expanded.text, end="")
        return
    check_file(options.out, [model_path(options.file)])
    with atomic_file(options.out) as partial:
        partial.write_text(expanded.text, encoding="utf-8")


def _left_out(finger: Finger) -> Iterator[str]:
    """Properties of a finger that plain URDF cannot express."""
    if finger.elastic_law is not None:
        yield "the springs follow Young's modulus; URDF cannot express an elastic law"
    if finger.creep:
        yield "the springs are the instantaneous ones; URDF cannot express creep"
    if any(finger.laws):
        yield "the joint drives must apply the pressure law; URDF cannot express it"
    if finger.tendons:
        yield "the joint drives must apply the tendons; URDF cannot express them"
