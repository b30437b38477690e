"""The same fingers and tasks in other simulators."""
