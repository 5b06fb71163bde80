"""Where a cart-pole and a four-bar end: both are motions of one coordinate u whose energy is constant.

    t = ∫ du/u̇(u)        u̇ = sqrt(2 (E − V(u))/m(u))

The integrands are smooth and periodic. mpmath integrates and inverts t(u). report.py calls ends(); README.md has the checks.

Cart-pole, let go at rest at θ_0 from the middle of its rail: no force along the rail, so s = (m r/(m_c + m)) (cos θ_0 − cos θ).
With ψ = θ + π/2 and sin(ψ/2) = k sin u, k = sin(ψ_0/2), the turning points lie at u = ±π/2, and

    u̇ = sqrt(m g r/(A − B cos² ψ)) cos(ψ/2)        A = I + m r², B = (m r)²/(m_c + m)

Four-bar: u is the crank's angle. The pin between coupler and rocker lies where two circles meet: on the side where it starts.
"""
import random

import mpmath
from mpmath import mpf

DRAWS = 4
PIECE = mpf(1) / 4  # of u, for each integral


def cart_pole(links, gravity, _):
    """(u at the start, u̇(u), coordinates and rates at u)"""
    cart, pole = links
    mass, reach = cart.mass + pole.mass, pole.mass * pole.com[0]
    about, shared = pole.inertia + reach * pole.com[0], reach**2 / mass
    start = pole.angle + mpmath.pi / 2
    k = mpmath.sin(start / 2)

    def psi(u):
        return 2 * mpmath.asin(k * mpmath.sin(u))

    def speed(u):
        return mpmath.sqrt(-gravity * reach / (about - shared * mpmath.cos(psi(u))**2)) * mpmath.cos(psi(u) / 2)

    def place(u):
        theta = psi(u) - mpmath.pi / 2
        rate = 2 * k * mpmath.cos(u) * speed(u) / mpmath.cos(psi(u) / 2)
        return ([reach / mass * (mpmath.cos(pole.angle) - mpmath.cos(theta)), theta],
                [reach / mass * mpmath.sin(theta) * rate, rate])

    return mpmath.pi / 2, speed, place


def four_bar(links, gravity, tip):
    crank, coupler, rocker = links

    def angles(u):
        """Absolute angles, and what they change by a radian of the crank; turns are those of the crank alone."""
        near = crank.pin[0] * mpmath.expj(u)
        across = tip - near
        length = abs(across)
        lean = mpmath.acos((coupler.pin[0]**2 + length**2 - rocker.pin[0]**2) / (2 * coupler.pin[0] * length))
        theta = mpmath.arg(across) + lean
        phi = mpmath.arg(tip - near - coupler.pin[0] * mpmath.expj(theta))
        # crank e^iu' + coupler e^iθ' + rocker e^iφ' = 0, along the rocker and along the coupler
        slope = crank.pin[0] / coupler.pin[0] * mpmath.sin(phi - u) / mpmath.sin(theta - phi)
        other = crank.pin[0] / rocker.pin[0] * mpmath.sin(theta - u) / mpmath.sin(phi - theta)
        return [u, theta, phi], [mpf(1), slope, other]

    def energies(u):
        """m, V"""
        m, V = mpf(0), mpf(0)
        pin, velocity = mpmath.mpc(0), mpmath.mpc(0)
        for link, angle, slope in zip(links, *angles(u)):
            e = mpmath.expj(angle)
            moves = velocity + 1j * slope * link.com[0] * e
            m += link.mass * abs(moves)**2 + link.inertia * slope**2
            V -= link.mass * gravity * (pin + link.com[0] * e).imag
            pin += link.pin[0] * e
            velocity += 1j * slope * link.pin[0] * e
        return m, V

    start = crank.angle
    m, V = energies(start)
    whole = m * crank.velocity**2 / 2 + V

    def speed(u):
        m, V = energies(u)
        return mpmath.sqrt(2 * (whole - V) / m)

    def place(u):
        theta, slopes = angles(u)
        return theta, [slope * speed(u) for slope in slopes]

    return start, speed, place


def motion(read, gravity, duration):
    """u is followed to t = duration. Coordinates, then rates."""
    links, tip = read
    start, speed, place = (four_bar if tip else cart_pole)(links, gravity, tip)
    u, left = start, mpf(duration)
    while True:  # whole pieces
        passes = mpmath.quad(lambda x: 1 / speed(x), [u, u + PIECE])
        if passes > left:
            break
        u, left = u + PIECE, left - passes
    while abs(left) > mpf(10)**(3 - mpmath.mp.dps):  # Newton's method
        step = left * speed(u)
        left -= mpmath.quad(lambda x: 1 / speed(x), [u, u + step])
        u += step
    places, rates = place(u)
    return places + rates


def disturbed(scene, draw):
    """Links and tip as wide numbers: as read, or each off by ±2⁻⁵³."""
    def wide(value):
        return mpf(value) * (1 + draw() * mpf(2)**-53)
    links = [type(link)(mass=wide(link.mass), inertia=wide(link.inertia), com=[wide(x) for x in link.com],
                        pin=[wide(x) for x in link.pin], angle=wide(link.angle), velocity=wide(link.velocity))
             for link in scene.links]
    return links, scene.tip and mpmath.mpc(*map(wide, scene.tip))


def ends(scene, duration):
    """Rows of value, uncertainty, rounding: θ of each link, or a slide's position, then the rates."""
    draw = random.Random(1)

    def run(digits, draw=lambda: 0):
        with mpmath.workdps(digits):
            return motion(disturbed(scene, draw), mpf(scene.gravity[1]), duration)

    fine, coarse = run(40), run(30)
    others = [run(20, lambda: draw.choice((-1, 1))) for _ in range(DRAWS)]
    return [[mpmath.nstr(value, 20, strip_zeros=False), mpmath.nstr(abs(value - coarse[k]), 3, min_fixed=0, max_fixed=0),
             mpmath.nstr(max(abs(value - other[k]) for other in others), 3, min_fixed=0, max_fixed=0)]
            for k, value in enumerate(fine)]
