"""Drake's own plant in the place of plants in another engine: one environment, with the same interface."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.arm import _set_gains, make_arm
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.diagrams.wiring.drive import _hold_straight


class DrakePlants:
    """A plant that Drake steps outside of the diagram of its station."""

    def __init__(self, station):
        scenario, builder = station.scenario, DiagramBuilder()
        models, arm = scenario.models, scenario.arm
        scene = add_plant(builder, scenario, visuals=False)
        self._plant = plant = scene.plant
        if arm is not None:
            _set_gains(plant, make_arm(plant, models, arm, scene.fingers))
        for finger in scene.fingers:
            if finger.has_implicit_springs:
                _hold_straight(builder, finger)
                break
        diagram = builder.Build()
        self._simulator = Simulator(diagram)
        self._context = plant.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())
        self.active, self._steps = np.array([0]), 0
        self.look()
        self._ports, self._given, self._scheduled = {}, {}, []

    def look(self):
        self.state = self._plant.GetPositionsAndVelocities(self._context)[None].copy()

    def drive(self, model, torques, desired):
        self._given[model] = np.ravel(torques).copy(), None if desired is None else np.ravel(desired).copy()
        self._plant.get_actuation_input_port(model).FixValue(self._context, self._given[model][0])
        arm = desired is not None and self._plant.GetModelInstanceName(model) == "arm"
        if arm:
            self._plant.get_desired_state_input_port(model).FixValue(self._context, self._given[model][1])

    def schedule(self):
        self._scheduled.append(dict(self._given))

    def step(self, keeps=False):
        for given in self._scheduled:
            for model, (torques, desired) in given.items():
                self.drive(model, torques, desired)
            self.begin_step()
            self.finish_step()
        self._scheduled.clear()

    def begin_step(self):
        """Contact follows from the inputs at the begin of a step."""
        plant = self._plant
        for name in ("generalized_contact_forces", "net_actuation"):
            of = getattr(plant, f"get_{name}_output_port")
            for model in self._models():
                self._ports[name, model] = of(model).Eval(self._context)[None].copy()
        self._poses = plant.get_body_poses_output_port().Eval(self._context)

    def finish_step(self):
        self._steps += 1  # a sum of steps would drift off the times at which the plant steps
        self._simulator.AdvanceTo(self._steps * self._plant.time_step())

    def model_ports(self, model):
        plant, nq = self._plant, self._plant.num_positions()
        q = plant.GetPositionsFromArray(model, np.arange(nq)).astype(int)
        v = plant.GetVelocitiesFromArray(model, np.arange(plant.num_velocities())).astype(int)
        return {
            "state": lambda: self.state[:, np.concatenate([q, nq + v])],
            "generalized_contact_forces": lambda: self._ports["generalized_contact_forces", model],
            "net_actuation": lambda: self._ports["net_actuation", model],
        }

    def pose(self, body):
        return self._plant.get_body(body).EvalPoseInWorld(self._context).GetAsMatrix34()[None]

    def _models(self):
        from pydrake.multibody.tree import ModelInstanceIndex

        return map(ModelInstanceIndex, range(self._plant.num_model_instances()))
