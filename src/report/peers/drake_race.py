#!/usr/bin/env python3
"""Drake as a contestant of the report: a MultibodyPlant in continuous time without a scene graph, and Simulator's integrators.

After a rejected step its methods 3(2) and 5(4) start from the derivative of the rejected state. A first step of 1e-5 s avoids most of
these; without caching it does not happen, at five times the cost.
"""
import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, RevoluteJoint, RevoluteSpring, RotationalInertia, SpatialInertia, UnitInertia
from pydrake.math import RigidTransform
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

import contest as contests

FIRST = 1e-5  # s
LONGEST = 20  # links
Z = [0, 0, 1]


def plant_of(contest):
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector([*contest.gravity, 0])
    inner, at = plant.world_frame(), [0, 0, 0]
    for i, (link, joint) in enumerate(zip(contest.links, contest.joints)):
        inertia = RotationalInertia(*[link["mass"] if "axis" in joint else link["inertia"]] * 3)  # a cart does not turn: any will do
        com = np.array([*link["com"], 0])
        about_pin = SpatialInertia.MakeFromCentralInertia(link["mass"], com, inertia)
        body = plant.AddRigidBody(str(i), about_pin)
        if joint.get("type") == "prismatic":
            made = PrismaticJoint(f"joint{i}", inner, body.body_frame(), [*joint["axis"], 0])
        else:
            frame = plant.AddFrame(FixedOffsetFrame(f"pin{i}", inner, RigidTransform(at)))
            made = RevoluteJoint(f"joint{i}", frame, body.body_frame(), Z, joint["damping"])
        added = plant.AddJoint(made)
        if joint["stiffness"]:
            plant.AddForceElement(RevoluteSpring(added, joint["rest_angle"], joint["stiffness"]))
        inner, at = body.body_frame(), [*link["pin"], 0]
    plant.Finalize()
    return plant


class Run:
    def __init__(self, contest, setting, scheme, has_fixed_step):
        self.contest = contest
        self.plant = plant_of(contest)
        self.simulator = Simulator(self.plant)
        self.integrator = ResetIntegratorFromFlags(self.simulator, scheme, setting if has_fixed_step else 0.1)
        self.integrator.set_fixed_step_mode(has_fixed_step)
        if not has_fixed_step:
            self.integrator.set_target_accuracy(setting)
            self.integrator.set_requested_minimum_step_size(1e-12)
            self.integrator.request_initial_step_size_target(FIRST)

    def start(self):
        context = self.simulator.get_mutable_context()
        context.SetTime(0)
        self.plant.SetPositions(context, self.contest.q)
        self.plant.SetVelocities(context, self.contest.qd)
        self.simulator.Initialize()
        self.simulator.ResetStatistics()

    def go(self):
        try:
            self.simulator.AdvanceTo(self.contest.end)
        except RuntimeError:
            return False
        return True

    def read(self):
        context, integrator = self.simulator.get_context(), self.integrator
        return (self.contest.absolute(self.plant.GetPositions(context)), self.contest.absolute(self.plant.GetVelocities(context)),
                integrator.get_num_derivative_evaluations(), integrator.get_num_steps_taken(),
                integrator.get_num_step_shrinkages_from_error_control())


def takes(contest):
    return contest.is_plain and len(contest) <= LONGEST


def method(name, scheme, has_fixed_step=False, suits=takes):
    return contests.Method(name, has_fixed_step, suits, lambda contest, setting: Run(contest, setting, scheme, has_fixed_step))


METHODS = [method("RK5", "runge_kutta5"), method("RK5 with equal steps", "runge_kutta5", True), method("RK3", "runge_kutta3"),
           method("Radau3", "radau3", suits=lambda contest: takes(contest) and contest.has_springs)]

if __name__ == "__main__":
    contests.main("Drake", METHODS)
