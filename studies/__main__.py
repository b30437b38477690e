"""The command line: `python -m studies NAME`."""

import sys

from soft_gripper.commands import main
from studies.commands import STUDIES

if __name__ == "__main__":
    sys.exit(main(program=STUDIES))
