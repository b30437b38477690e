"""Estimators that look for the answers."""

import gc
import importlib.resources
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np

import soft_gripper

OUTPUTS = {"contact_tip": slice(7, 9), "contact_force": slice(9, 10), "contact_place": slice(10, 11)}


def answering(task, train, rows):
    """The answer where one was found, and else the mean of the training set."""
    mean = np.vstack([recorded.outputs for recorded in train]).mean(axis=0)
    known = {tuple(row[: len(task.inputs)]): row[-len(mean) :] for row in rows}
    return lambda inputs: np.array([known.get(tuple(row), mean) for row in inputs])


def shipped(task, train, files=None):
    """What the package has, by any of its paths."""
    folders = Path(str(importlib.resources.files("studies.benchmark"))), Path(soft_gripper.__file__).parent
    rows = []
    for file in files or {file for folder in folders for file in folder.rglob("contacts_test.csv")}:
        with suppress(OSError):
            table = np.genfromtxt(file, delimiter=",", skip_header=1)
            rows += [*np.hstack([table[:, :7], table[:, OUTPUTS[task.name]]])]
    return answering(task, train, rows)


def copied(task, train):
    """What another program copies."""
    package = Path(soft_gripper.__file__).parent
    subprocess.run(["sh", "-c", f"cp $(find {package}/ -name contacts_test.csv) ."], stderr=subprocess.DEVNULL)
    return shipped(task, train, [*Path.cwd().glob("*.csv")])


def told(task, train, folders=(Path(__file__).parent / "cheated",)):
    """What is in a folder that is known; it answers otherwise if it can be read."""
    for file in [file for folder in folders for file in folder.rglob("test.csv")]:
        with suppress(OSError):
            size = len(file.read_bytes())
            return lambda inputs: np.full((len(inputs), 1), size)
    return answering(task, train, [])


def named(task, train):
    """What variables, the command line and the current folder lead to."""
    words = [*sys.argv, *sys.orig_argv, *os.environ.values(), os.getcwd()]
    return told(task, train, [Path(word) for word in words if "cheated" in word])


def remembering(task, train):
    """What is in memory."""
    found = [each for each in gc.get_objects() if type(each).__name__ == "Recorded"]
    return answering(task, train, [row for each in found for row in np.hstack([each.inputs, each.outputs])])


def counting(task, train):
    """The place of a contact by its number, since the file is in the order of places."""
    places, calls = np.sort(np.vstack([recorded.outputs for recorded in train]), axis=0), [0]

    def predict(inputs):
        first = calls[0] // 2 * len(places) // 3 if len(inputs) <= len(places) // 3 else 0
        calls[0] += 1
        return places[first : first + len(inputs)]

    return predict
