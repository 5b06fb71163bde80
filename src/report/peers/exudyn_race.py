#!/usr/bin/env python3
"""Exudyn as a contestant of the report: an open chain as a kinematic tree in joint coordinates, a closed one as plane rigid bodies
with revolute joints. DOPRI5 is its best explicit method; RK44 and ODE23, the others of this kind, take longer to every error.
The module without range checks; no output, sensors and graphics.

Its scale of errors is atol + rtol max(x0, x1) without absolute values, so that rtol is 0 here.
"""
import contextlib
import sys

import numpy as np

import contest as contests

sys.exudynFast = True
with contextlib.redirect_stdout(None):
    import exudyn as exu
    from exudyn import itemInterface as items

LONGEST = 20  # links
SOLVERS = exu.DynamicSolverType
SLOPES = {(1, 0): exu.JointType.PrismaticX, (0, 1): exu.JointType.PrismaticY}


class Tree:
    """Joint coordinates; springs and dampers as its P and D control."""

    def __init__(self, contest, system):
        self.contest, self.state, n = contest, system.systemData, len(contest)
        joints, links = contest.joints, contest.links
        node = system.AddNode(items.NodeGenericODE2(referenceCoordinates=[0] * n, initialCoordinates=contest.q,
                                                    initialCoordinates_t=contest.qd, numberOfODE2Coordinates=n))
        control = dict(jointPositionOffsetVector=[joint["rest_angle"] for joint in joints], jointVelocityOffsetVector=[0] * n,
                       jointPControlVector=[joint["stiffness"] for joint in joints],
                       jointDControlVector=[joint["damping"] for joint in joints]) if contest.has_springs else {}
        system.AddObject(items.ObjectKinematicTree(
            nodeNumber=node, gravity=[*contest.gravity, 0], linkParents=list(range(-1, n - 1)),
            jointTypes=[SLOPES[tuple(joint["axis"])] if "axis" in joint else exu.JointType.RevoluteZ for joint in joints],
            jointTransformations=exu.Matrix3DList([np.eye(3)] * n),
            jointOffsets=exu.Vector3DList([[0, 0, 0], *([*link["pin"], 0] for link in links[:-1])]),
            linkInertiasCOM=exu.Matrix3DList([link["inertia"] * np.eye(3) for link in links]),
            linkCOMs=exu.Vector3DList([[*link["com"], 0] for link in links]),
            linkMasses=[link["mass"] for link in links], **control))

    def angles(self):
        return self.contest.absolute(self.state.GetODE2Coordinates()), self.contest.absolute(self.state.GetODE2Coordinates_t())


class Bodies:
    """x, y and the angle of each body at its centre of mass; the tip held at a point."""

    def __init__(self, contest, system):
        self.state, self.first = system.systemData, np.array(contest.absolute(contest.q))
        ground = system.AddObject(items.ObjectGround())
        last, pin, pin_rate = ground, np.zeros(2), np.zeros(2)
        local = [0, 0]
        for link, theta, omega in zip(contest.links, self.first, contest.absolute(contest.qd)):
            turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
            quarter = np.array([[0, -1], [1, 0]])
            com, arm = np.array(link["com"]), np.array(link["pin"])
            node = system.AddNode(items.NodeRigidBody2D(
                referenceCoordinates=[*(pin + turn @ com), theta],
                initialVelocities=[*(pin_rate + omega * quarter @ turn @ com), omega]))
            body = system.AddObject(items.ObjectRigidBody2D(mass=link["mass"], inertia=link["inertia"], nodeNumber=node))
            weight = system.AddMarker(items.MarkerBodyMass(bodyNumber=body))
            system.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=[*contest.gravity, 0]))
            self.join(system, (last, local), (body, -com))
            last, local = body, arm - com
            pin, pin_rate = pin + turn @ arm, pin_rate + omega * quarter @ turn @ arm
        self.join(system, (last, local), (ground, [contest.tip["pin"][axis]["offset"] for axis in "xy"]))

    @staticmethod
    def join(system, *places):
        markers = [system.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[*at, 0])) for body, at in places]
        system.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))

    def angles(self):
        return self.first + self.state.GetODE2Coordinates()[2::3], self.state.GetODE2Coordinates_t()[2::3]


class Run:
    def __init__(self, contest, setting, solver, has_fixed_step):
        self.system = exu.SystemContainer().AddSystem()
        self.model = (Bodies if contest.tip else Tree)(contest, self.system)
        self.system.Assemble()
        self.settings = exu.SimulationSettings()
        self.settings.solution.file.write = self.settings.solution.sensors.active = False
        integration = self.settings.timeIntegration
        integration.solverType = solver
        integration.endTime = contest.end
        integration.numberOfSteps = round(contest.end / (setting if has_fixed_step else 0.1))
        integration.automaticStepSize = integration.adaptiveStep = not has_fixed_step
        integration.explicit.useLieGroupIntegration = integration.explicit.computeEndOfStepAccelerations = False
        self.is_implicit = solver in (SOLVERS.GeneralizedAlpha, SOLVERS.TrapezoidalIndex2)
        if self.is_implicit:
            is_trapezoidal = solver == SOLVERS.TrapezoidalIndex2
            integration.generalizedAlpha.useNewmark = integration.generalizedAlpha.useIndex2Constraints = is_trapezoidal
            integration.newton.modifiedNewtonContractivity = 0.1
            integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-10, 1e-12
        else:
            integration.absoluteTolerance, integration.relativeTolerance = setting, 0
            integration.initialStepSize, integration.minimumStepSize = 1e-4, 1e-12

    def start(self):
        self.solver = exu.MainSolverImplicitSecondOrder() if self.is_implicit else exu.MainSolverExplicit()

    def go(self):
        return self.solver.SolveSystem(self.system, self.settings)

    def read(self):
        return (*self.model.angles(), 0, self.solver.it.currentStepIndex, self.solver.it.rejectedAutomaticStepSizeSteps)


def is_open(contest):
    return contest.is_plain and len(contest) <= LONGEST


def is_closed(contest):
    return contest.tip is not None and not contest.has_springs


def either(contest):
    return is_open(contest) or is_closed(contest)


def method(name, solver, takes, has_fixed_step=False):
    return contests.Method(name, has_fixed_step, takes, lambda contest, setting: Run(contest, setting, solver, has_fixed_step))


METHODS = [method("DOPRI5", SOLVERS.DOPRI5, is_open), method("RK67", SOLVERS.RK67, is_open, True),
           method("generalized-α", SOLVERS.GeneralizedAlpha, either, True),
           method("trapezoidal index 2", SOLVERS.TrapezoidalIndex2, is_closed, True)]

if __name__ == "__main__":
    contests.main("Exudyn", METHODS)
