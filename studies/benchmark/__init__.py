"""A benchmark of proprioception on recorded hardware: tasks with fixed splits, baselines and scores."""
