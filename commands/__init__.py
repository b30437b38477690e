"""The command line: `soft-gripper COMMAND`, one file a command."""

from soft_gripper.commands.main import main

__all__ = ["main"]
