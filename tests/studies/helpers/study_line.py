"""The command line of the studies, called in process as a user calls it."""

from functools import partial

from command_line import soft_gripper

from studies.commands import STUDIES

study_line = partial(soft_gripper, program=STUDIES)
