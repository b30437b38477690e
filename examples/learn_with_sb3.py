"""Learns SoftReach-v0 with the PPO of Stable-Baselines3, which is not a dependency: pip install stable-baselines3.

python examples/learn_with_sb3.py [STEPS]
"""

import sys

from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import SubprocVecEnv

import soft_gripper.extras.learning  # noqa: F401  registers

if __name__ == "__main__":  # processes import this file
    envs = make_vec_env("SoftReach-v0", n_envs=2, seed=0, vec_env_cls=SubprocVecEnv)
    model = PPO("MlpPolicy", envs, n_steps=500, batch_size=100, gamma=0.9, seed=0, verbose=1)
    before = evaluate_policy(model, envs, n_eval_episodes=10)
    model.learn(total_timesteps=int(sys.argv[1]) if len(sys.argv) > 1 else 20_000)
    after = evaluate_policy(model, envs, n_eval_episodes=10)
    print(f"mean reward of an episode, of 5 at most: {before[0]:.2f} before, {after[0]:.2f} after")
