#!/usr/bin/python3
"""A Kalman filter of a pendulum: it is fed by an encoder and the gyroscope of an IMU, and judged by the truth.

The state is [angle, rate, bias of the gyroscope]. The angle is coarse and late, the rate drifts.

    filter.py
"""
import numpy as np
from planar_chain import Scene, Simulation

RATE, RESOLUTION, GYRO_NOISE, WALK = 200, 0.02, 0.02, 0.01
SCENE = {
    "chain": ["rod"],
    "links": {"rod": {"mass": 1.0, "inertia": 1 / 12, "com": [0.5, 0.0], "pin": [1.0, 0.0], "joint": {"damping": 0.05}}},
    "sensors": {
        "encoder": {"joints": "all", "resolution": RESOLUTION, "rate": RATE},
        "imu": {"link": "rod", "gyro_noise": GYRO_NOISE, "gyro_bias": 0.1, "gyro_bias_walk": WALK, "rate": RATE}},
    "seed": 1}


def acceleration(angle, rate):
    return (-0.5 * 9.81 * np.cos(angle) - 0.05 * rate) * 3


def predict(x, P):
    h = 1 / RATE
    A = np.array([[1, h, 0], [1.5 * 9.81 * np.sin(x[0]) * h, 1 - 0.15 * h, 0], [0, 0, 1]])
    x = np.array([x[0] + h * x[1], x[1] + h * acceleration(x[0] + h / 2 * x[1], x[1]), x[2]])
    return x, A @ P @ A.T + np.diag([1e-10, 1e-6, WALK ** 2 * h])


def correct(x, P, H, measured, variance):
    gain = P @ H / (H @ P @ H + variance)
    return x + gain * (measured - H @ x), P - np.outer(gain, H @ P)


def main():
    simulation = Simulation(Scene(SCENE))
    x, P = np.array([0.0, 0.0, 0.0]), np.diag([1e-2, 1e-2, 1e-1])
    errors = []
    for k in range(1, 20 * RATE + 1):
        simulation.advance_to(k / RATE)
        x, P = predict(x, P)
        for one in simulation.measure():
            if one.time == 0:
                continue
            if one.sensor == "encoder":
                x, P = correct(x, P, np.array([1.0, 0, 0]), one.values[0], RESOLUTION ** 2 / 12)
                raw = one.values[0]
            else:
                x, P = correct(x, P, np.array([0, 1.0, 1.0]), one.values[2], GYRO_NOISE ** 2)
        if k > 2 * RATE:  # it has settled
            errors.append([raw - simulation.q[0], x[0] - simulation.q[0], x[1] - simulation.qd[0]])
    encoder, angle, rate = np.sqrt(np.mean(np.square(errors), axis=0))
    print(f"the encoder is off by {encoder:.5f} rad, the filter by {angle:.5f} rad and {rate:.4f} rad/s (root mean square)")


if __name__ == "__main__":
    main()
