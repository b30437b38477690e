"""The addition of this extra: what shows the scene of a run in a browser."""

VIEWERS = {"meshcat": "soft_gripper.extras.page.viewing:show_meshcat"}
