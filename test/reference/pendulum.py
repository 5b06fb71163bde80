#!/usr/bin/python3
"""The exact motion of a point pendulum, by Jacobi's elliptic functions. Writes pendulum.csv.

A mass on a massless rod of length 1 m, g = the double nearest 9.81 m/s², ω0² = g/l. With φ from the hanging
position, k = sin(φ0/2):

    released from rest at φ0:        sin(φ/2) = k cd(ω0 t, k)        period 4 K(k)/ω0
    hanging, struck to φ̇0 > 2 ω0:   φ = 2 am(φ̇0 t/2, κ), κ = 2 ω0/φ̇0;    sin(φ/2) = sn, φ̇ = φ̇0 dn
                                                                     period (one turn) 4 K(κ)/φ̇0

The program's angle q is measured from +x: q = φ − π/2. mpmath takes the parameter m = k². Each value is
computed with 40 and with 60 digits, and the equation of motion is checked by a numerical derivative.
"""

import pathlib

import mpmath
from mpmath import mpf

G = mpf(9.81)
TIMES = [0.25, 0.5, 1, 2, 5, 10]


def swing(t, phi0):
    """φ and φ̇."""
    w = mpmath.sqrt(G)
    m = mpmath.sin(phi0 / 2)**2
    k = mpmath.sqrt(m)
    sn, cn, dn = (mpmath.ellipfun(name, w * t, m=m) for name in ("sn", "cn", "dn"))
    phi = 2 * mpmath.asin(k * cn / dn)
    # d cd/du = −(1 − m) sn/dn²
    return phi, 2 * k * w * (-(1 - m) * sn / dn**2) / mpmath.cos(phi / 2)


def turn(t, rate0):
    w = mpmath.sqrt(G)
    m = 4 * w**2 / rate0**2
    u = rate0 * t / 2
    sn, cn, dn = (mpmath.ellipfun(name, u, m=m) for name in ("sn", "cn", "dn"))
    turns = mpmath.floor(u / (4 * mpmath.ellipk(m)) + mpf(1) / 2)  # sn, cn repeat after 4 K: am grows by 2 π
    return 2 * (mpmath.atan2(sn, cn) + 2 * mpmath.pi * turns), rate0 * dn


def cases():
    """Name, φ and φ̇ as functions of t, period."""
    w = mpmath.sqrt(G)
    horizontal = mpmath.pi / 2
    return [
        ("horizontal", lambda t: swing(t, horizontal), 4 * mpmath.ellipk(mpf(1) / 2) / w),
        ("over_the_top", lambda t: turn(t, mpf(8)), 4 * mpmath.ellipk(4 * G / 64) / 8),
    ]


def rows():
    for name, motion, period in cases():
        yield name, "period", "", period
        for t in TIMES:
            phi, rate = motion(mpf(t))
            yield name, "q", t, phi - mpmath.pi / 2
            yield name, "qd", t, rate


def main():
    with mpmath.workdps(60):
        fine = list(rows())
    with mpmath.workdps(40):
        coarse = list(rows())
        for _, motion, _ in cases():
            for t in TIMES:
                slope = mpmath.diff(lambda x: motion(x)[1], mpf(t))
                assert abs(slope + G * mpmath.sin(motion(mpf(t))[0])) < mpf(10)**-15
                assert abs(mpmath.diff(lambda x: motion(x)[0], mpf(t)) - motion(mpf(t))[1]) < mpf(10)**-15
    lines = ["motion,quantity,t,value"]
    for (name, quantity, t, a), (*_, b) in zip(fine, coarse):
        assert abs(a - b) < mpf(10)**-30
        lines.append(f"{name},{quantity},{t},{mpmath.nstr(a, 20, strip_zeros=False)}")
    (pathlib.Path(__file__).parent / "pendulum.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
