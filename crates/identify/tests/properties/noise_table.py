"""The expected digits of noise_table.rs, computed with 40 digits by explicit inverses (mpmath)."""

from mpmath import cos, inverse, matrix, mp, mpf, nstr, pi, sin, sqrt

mp.dps = 40
ARCSEC_PER_MRAD = 180 * 3600 / pi / 1000
PAPER_ROWS = (0, 1, 3, 5, 7, 8)

THREE_AXIS = ("16.338 452.716 122.416", "157.086 332.593 324.879", "248.925 603.0552 412.4483")
ROTARY = ("-105.8046 135.3414 0", "128.8513 87.8158 39.9797", "24.9026 -110.8575 15.2662")


def targets(texts):
    return [[mpf(number) for number in text.split()] for text in texts]


def equations(r):
    rows = []
    for x, y, z in r:
        rows += [[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]]
    return rows


def print_noise(name, operator):
    sigma = [sqrt(sum(operator[i, k] ** 2 for k in range(operator.cols))) for i in range(6)]
    sigma[3:] = [s * ARCSEC_PER_MRAD for s in sigma[3:]]
    print(name, *(nstr(s, 7) for s in sigma))


def report(name, r):
    a = matrix(equations(r))
    print_noise(name + " nine", inverse(a.T * a) * a.T)
    print_noise(name + " six ", inverse(matrix([equations(r)[i] for i in PAPER_ROWS])))


report("three-axis", targets(THREE_AXIS))
angle = 140 * pi / 180
report("rotary 140°", [[x * cos(angle) - y * sin(angle), x * sin(angle) + y * cos(angle), z]
                       for x, y, z in targets(ROTARY)])
