"""What theories of laminates, beams and shells say of loaded walls."""

import numpy as np


def ply_stiffness(ply):
    """Stiffness of a ply in the axes of the wall by its engineering constants, (3, 3) [Pa].

    R. M. Jones, Mechanics of Composite Materials, 2nd edition (1999), eqs (2.70) and (2.85).
    """
    material = ply.material
    (E1, E2, _), G12, nu12 = material.young, material.shear[0], material.poisson[0]
    share = 1.0 / (1.0 - nu12**2 * E2 / E1)
    Q11, Q22, Q12, Q66 = share * E1, share * E2, share * nu12 * E2, G12
    c, s = np.cos(ply.angle), np.sin(ply.angle)
    q11 = Q11 * c**4 + 2 * (Q12 + 2 * Q66) * s**2 * c**2 + Q22 * s**4
    q22 = Q11 * s**4 + 2 * (Q12 + 2 * Q66) * s**2 * c**2 + Q22 * c**4
    q12 = (Q11 + Q22 - 4 * Q66) * s**2 * c**2 + Q12 * (s**4 + c**4)
    q66 = (Q11 + Q22 - 2 * Q12 - 2 * Q66) * s**2 * c**2 + Q66 * (s**4 + c**4)
    q16 = (Q11 - Q12 - 2 * Q66) * s * c**3 + (Q12 - Q22 + 2 * Q66) * s**3 * c
    q26 = (Q11 - Q12 - 2 * Q66) * s**3 * c + (Q12 - Q22 + 2 * Q66) * s * c**3
    return np.array([[q11, q12, q16], [q12, q22, q26], [q16, q26, q66]])


def strip(plies, resultant, bend):
    """Strains in the middle and curvatures of a strip by classical lamination theory.

    Args:
        plies: The laminate.
        resultant: Force [N/m], or moment [N] if it bends, along the strip per width.
        bend: Which of them.

    Returns:
        (e11, e22, 2 e12) and (k11, k22, 2 k12) [1/m].
    """
    z = 0.5 * sum(ply.thickness for ply in plies)  # of the outer face of a ply
    stiffness = np.zeros((6, 6))
    for ply in plies:
        below = z - ply.thickness
        A, B, D = ((z**k - below**k) / k * ply_stiffness(ply) for k in (1, 2, 3))
        stiffness += np.block([[A, B], [B, D]])
        z = below
    load = np.zeros(6)
    load[3 if bend else 0] = resultant
    return np.split(np.linalg.solve(stiffness, load), 2)


def second_moment(r, t):
    """Second moment of area of a tube of the radius r in the middle of its wall t [m^4]."""
    return np.pi / 4 * ((r + t / 2) ** 4 - (r - t / 2) ** 4)


def bent_tube(radius, thickness, length, young, shear, force):
    """Deflection of a clamped tube under a force at its end, by Timoshenko's theory [m].

    In a tapered tube the generators are inclined by alpha. The tension along them, which bends the
    tube, has the part M tan(alpha)/r across it, by which the shear is smaller; it is larger than in
    a straight tube by 1/cos(alpha), as is the length of the generators, and the wall is thinner.
    """
    s = (np.arange(20000) + 0.5) / 20000
    r, t, arm = radius(s), thickness(s), length * (1.0 - s)
    tan = (radius(0.0) - radius(1.0)) / length
    shear_area = np.pi * r * t  # half of the area
    compliance = arm**2 / (young * second_moment(r, t)) * (1.0 + tan**2) ** 2
    compliance += (1.0 - arm * tan / r) ** 2 / (shear * shear_area)
    return force * np.mean(compliance) * length


def oval_tube(r, t, length, young, poisson, size):
    """How far a clamped tube becomes oval under a traction at its end, by Vlasov's theory [m].

    The traction is ``size`` times (y, -z)/r. Rings keep their length, w = W(x) cos 2 phi and
    v = -W/2 sin 2 phi, and there is no shear in the wall, u = -r/4 W' cos 2 phi. Stretching along
    the generators and bending of the rings have the energy

        pi r/2 int E t r^2/16 W''^2 + 9 D/r^4 W^2 dx,   D = E t^3/(12 (1 - nu^2)),

    that of a beam on an elastic foundation, with the force 3/2 pi r t at the end.

    Returns:
        W at the end.
    """
    stiffness = young * t * r**2 / 16.0
    foundation = 9.0 * young * t**3 / (12.0 * (1.0 - poisson**2)) / r**4
    beta = (foundation / (4.0 * stiffness)) ** 0.25
    x, force = beta * length, 1.5 * t * size
    ratio = (np.sinh(x) * np.cosh(x) - np.sin(x) * np.cos(x)) / (np.cosh(x) ** 2 + np.cos(x) ** 2)
    return force * ratio / (2.0 * beta**3 * stiffness)
