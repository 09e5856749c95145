/* Any lines against one rod: where they enter and leave, by the quick formulas alone.

   A bound for the library's time, not a rival: a line that nearly touches, that is nearly parallel or
   level, or whose point is far away is marked (0 in `sure`) and left to others.

       gcc -O3 -march=x86-64-v3 -ffp-contract=off -fno-math-errno -shared -fPIC rod.c -o rod.so -lm */

#include <math.h>

static double lesser(double a, double b) { return a <= b ? a : b; }
static double greater(double a, double b) { return a >= b ? a : b; }

void meet_lines(long count, const double *a, const double *b, const double *radii, const double *points,
                const double *directions, double *enter, double *leave, char *sure)
{
    const double close = 1e-6, far = 6.0, range = 1e20, r = radii[0];
    double v0 = b[0] - a[0], v1 = b[1] - a[1], v2 = b[2] - a[2];
    double vv = v0 * v0 + v1 * v1 + v2 * v2;
    for (long i = 0; i < count; i++) {
        const double *p = points + 3 * i, *u = directions + 3 * i;
        double q0 = p[0] - a[0], q1 = p[1] - a[1], q2 = p[2] - a[2];
        double n0 = u[1] * v2 - u[2] * v1, n1 = u[2] * v0 - u[0] * v2, n2 = u[0] * v1 - u[1] * v0;
        double nn = n0 * n0 + n1 * n1 + n2 * n2, aside = q0 * n0 + q1 * n1 + q2 * n2;
        double uu = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
        double size = (q0 * q0 + q1 * q1 + q2 * q2) * (uu * vv);
        int beside = aside * aside > (1 + 10 * close) * r * r * nn + 1e-23 * size;
        double qv = q0 * v0 + q1 * v1 + q2 * v2, uv = u[0] * v0 + u[1] * v1 + u[2] * v2;
        double m0 = q1 * v2 - q2 * v1, m1 = q2 * v0 - q0 * v2, m2 = q0 * v1 - q1 * v0;
        double middle = -(m0 * n0 + m1 * n1 + m2 * n2) / nn;
        double room = r * r * nn - aside * aside;
        double half = sqrt(greater(room, 0.0) * vv) / nn;
        double one = -qv / uv, other = (vv - qv) / uv, low = lesser(one, other), high = greater(one, other);
        double first = greater(low, middle - half), last = lesser(high, middle + half);
        int certain = (size <= far * far * nn * (r * r + nn / uu)) & (uu < range * range)
            & (uu > 1 / range / range) & (room > close * r * r * nn) & (uv * uv > close * close * uu * vv)
            & (fabs(last - first) > close * (half + (high - low)));
        int hit = !beside & (first <= last);
        enter[i] = hit ? first : INFINITY;
        leave[i] = hit ? last : -INFINITY;
        sure[i] = beside | certain;
    }
}
