"""Gymnasium environments of soft grippers; to import this registers SoftReach-v0, SoftGrasp-v0 and SoftPickPlace-v0."""

from .environment import SoftGripperEnv as SoftGripperEnv
from .gentle_grasp.compare import saved_force as saved_force
from .gentle_grasp.episodes import hand_tuned_environment as hand_tuned_environment
from .gentle_grasp.episodes import run_episodes as run_episodes
from .gentle_grasp.learn import learn as learn
from .gentle_grasp.learned import load_learned as load_learned
from .gentle_grasp.learning_figure import learning_figure as learning_figure
from .gentle_grasp.policies import GentleGrasp as GentleGrasp
from .gentle_grasp.policies import GentleParameters as GentleParameters
from .gentle_grasp.policies import HandTuned as HandTuned
from .gentle_grasp.policies import grip_torque as grip_torque
from .schema.environment_file import environment_names as environment_names
from .schema.environment_file import load_environment as load_environment
