"""Three fingers close around a mesh.

The opening follows set points until the torque limit holds the grip.
"""

import soft_gripper as sg

scenario = sg.Scenario(
    models=[
        sg.ModelConfig(
            name="gripper",
            file="package://soft_gripper/grippers/three_finger.urdf",
        ),
        sg.ModelConfig(
            name="apple",
            file="package://soft_gripper/objects/apple.obj",
            free=True,
        ),
    ],
    gravity=[0.0, 0.0, 0.0],  # the apple floats in front of the palm
    control=sg.ControlConfig(
        # m, twice the mean distance of the tips from their centroid
        set_points=[0.085, 0.03],
        hold=1.5,  # s
        # Pa/m, Pa/(m s), Pa s/m
        gains=sg.control.PidGains(kp=1.0e5, ki=5.7e6, kd=17.0),
        torque_limit=0.05,  # N m at the base of a finger
        # Pa/(N m), Pa/(N m s)
        torque_gains=sg.control.PidGains(kp=2e5, ki=4e6),
    ),
    estimator=sg.EstimatorConfig(contact_threshold=2.5e-3),  # N m
)
scenario.models[1].X_PC.translation = [0.0, 0.0, 0.13]  # m
scenario.models[1].mass = 0.06  # kg

recording = sg.simulate(scenario)
figure = recording.plot(
    "grip.opening",
    "grip.torque",
    "grip.object_width",
    "finger_1.contact",
    "apple.pose",
)
