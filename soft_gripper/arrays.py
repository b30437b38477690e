"""The array types used throughout."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
Planar = NDArray[np.complex128]  # vectors of the bending plane, z + i x, m (see kinematics)
