"""Studies that give the numbers of README and docs, run from a clone: `python -m studies --help` lists them.

Nothing in the wheel imports them.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.append(str(ROOT / "tests/helpers"))  # reference solutions that tests use too
