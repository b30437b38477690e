"""Gymnasium environments of soft grippers; to import this registers SoftReach-v0, SoftGrasp-v0 and SoftPickPlace-v0."""

import lazy_loader

try:
    import gymnasium
except ImportError:
    raise ImportError("soft_gripper.extras.learning needs Gymnasium: pip install 'soft-gripper[learning]'") from None

for _id, _environment in (
    ("SoftReach-v0", "soft_reach"),
    ("SoftGrasp-v0", "soft_grasp"),
    ("SoftPickPlace-v0", "soft_pick_place"),
):
    gymnasium.register(
        _id,
        f"{__name__}.environment:SoftGripperEnv",
        vector_entry_point=f"{__name__}.vector_environment:SoftGripperVectorEnv",
        kwargs={"environment": _environment},
    )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
