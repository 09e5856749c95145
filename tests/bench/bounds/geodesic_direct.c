/* Ends of geodesics of given starts on the working sheet, with the answers of geodesic_direct: a bound.

   The same series and the same search, nodes side by side so that the compiler takes several at once.
   Nothing but that: no meridian, no ring, no way round the tube, no check. */

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { TERMS = 24, PANELS = 8 };

static const double WHOLE = 6755399441055744.0;

static inline double power_of_two(double shifted)
{
    int64_t bits;
    double power;
    memcpy(&bits, &shifted, 8);
    bits = (int64_t)((uint64_t)(bits + 1023) << 52);
    memcpy(&power, &bits, 8);
    return power;
}

/* exp(x) - 1 for x >= 0 */
static inline double growth(double x)
{
    static const double c[] = {1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 720, 1.0 / 5040,
                               1.0 / 40320, 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800,
                               1.0 / 479001600, 1.0 / 6227020800.0};
    double power = (x * 1.4426950408889634 + WHOLE) - WHOLE;
    double r = (x - power * 0.6931471803691238) - power * 1.9082149292705877e-10;
    double sum = c[11];
    for (int k = 10; k >= 0; k--) sum = sum * r + c[k];
    double scale = power_of_two(power + WHOLE);
    return scale * (r + sum * (r * r)) + (scale - 1);
}

/* sin(x) for x from 0 to pi/2 */
static inline double sine_of(double x)
{
    static const double c[] = {-1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800,
                               1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0,
                               -1.0 / 121645100408832000.0, 1.0 / 51090942171709440000.0};
    double z = x * x, sum = c[9];
    for (int k = 8; k >= 0; k--) sum = sum * z + c[k];
    return x + x * (z * sum);
}

static inline double series(const double *terms, double x)
{
    double twice = 2 * x, b = 0, before = 0;
    for (int k = TERMS; k > 0; k--) {
        double next = (terms[k] - before) + twice * b;
        before = b;
        b = next;
    }
    return (terms[0] - before) + x * b;
}

/* start is (3, n): theta, phi, azimuth in rad; length (n) in m; share (TERMS), integral
   (TERMS, TERMS + 1), found (3, n). Returns how many took no answer. */
long geodesic_direct(double r_in_m, double R, const double *start, const double *length, long n,
                     const double *share, const double *integral, double *found)
{
    double r = r_in_m / R;
    long failed = 0;
    for (long i = 0; i < n; i++) {
        double phi = start[n + i], sine = sin(start[2 * n + i]), cosine = cos(start[2 * n + i]);
        double side = sine < 0 ? -1 : 1;
        sine *= side;
        double half = sin(phi / 2), rho = r + cos(phi), c = rho * sine;
        double slope = cosine * sqrt(rho / (2 * (1 + sine)));
        double A = (1 - r + c) / 2, B = half * half + slope * slope;
        double width = fmin(sqrt(fmin(A, c / 2) / B), 3.0);
        double reach = asinh(1.5707963267948966 / width), t0 = atan2(-slope, half);
        int count = (int)ceil(reach / 1.2);
        if (count > PANELS) {
            failed++;
            continue;
        }
        double begun = rint(t0 / M_PI);
        t0 -= M_PI * begun;
        double step = reach / count, edges[2][PANELS + 1], terms[PANELS][2][TERMS + 1];
        edges[0][0] = edges[1][0] = 0;
        for (int panel = 0; panel < count; panel++) {
            double values[2][TERMS];
            for (int k = 0; k < TERMS; k++) {
                double grown = growth(step * (panel + share[k])), shrunk = grown / (1 + grown);
                double s = sine_of(width * ((grown + shrunk) / 2)), sin2 = s * s;
                double dt = width * (1 + (grown - shrunk) / 2) * (step / 2), here = c + 2 * B * sin2;
                double density = sqrt(2 / ((here + c) * (A + B * sin2))) * dt;
                values[0][k] = here * density;
                values[1][k] = c / here * density;
            }
            for (int one = 0; one < 2; one++) {
                double sum[TERMS + 1] = {0}, total = 0;
                for (int k = 0; k < TERMS; k++)
                    for (int j = 0; j <= TERMS; j++) sum[j] += integral[k * (TERMS + 1) + j] * values[one][k];
                for (int j = 0; j <= TERMS; j++) total += sum[j];
                memcpy(terms[panel][one], sum, sizeof sum);
                edges[one][panel + 1] = edges[one][panel] + total;
            }
        }
        double y = asinh(fabs(t0) / width) / step;
        int panel = y < count - 1 ? (int)y : count - 1;
        double x = 2 * (y - panel) - 1, sign = t0 < 0 ? -1 : 1;
        double before = sign * (edges[0][panel] + series(terms[panel][0], x));
        double turned = sign * (edges[1][panel] + series(terms[panel][1], x));
        double whole = 2 * edges[0][count], rest = length[i] / R + before, swings = rint(rest / whole);
        rest -= swings * whole;
        sign = rest < 0 ? -1 : 1;
        double size = fmin(fabs(rest), edges[0][count]);
        panel = 0;
        while (panel + 1 < count && edges[0][panel + 1] <= size) panel++;
        double wanted = size - edges[0][panel], last = INFINITY;
        x = 2 * wanted / (edges[0][panel + 1] - edges[0][panel]) - 1;
        for (int round = 0; round < 30 && last > 1e-8; round++) {
            const double *a = terms[panel][0];
            double twice = 2 * x, b = 0, b2 = 0, d = 0, d2 = 0;
            for (int k = TERMS; k > 0; k--) {
                double dn = (2 * b - d2) + twice * d, bn = (a[k] - b2) + twice * b;
                d2 = d;
                d = dn;
                b2 = b;
                b = bn;
            }
            double missing = wanted - ((a[0] - b2) + x * b);
            double moved = fmax(-1.0, fmin(1.0, x + missing / ((b - d2) + x * d)));
            last = fabs(moved - x);
            x = moved;
        }
        failed += !(last <= 1e-8);
        double beyond = sign * (edges[1][panel] + series(terms[panel][1], x));
        double t = sign * width * sinh(step * (panel + (1 + x) / 2)), s = sin(t), here = c + 2 * B * s * s;
        swings += begun;
        double across = (fmod(swings, 2) == 0 ? 1 : -1) * sqrt(B);
        double end = 2 * atan2(across * cos(t), sqrt(A + B * s * s));
        double azimuth = atan2(c / here, -across * s * (sqrt(2 * (here + c)) / here));
        found[i] = start[i] + side * (beyond - turned + (swings - begun) * 2 * edges[1][count]);
        found[n + i] = end;
        found[2 * n + i] = side * azimuth;
    }
    return failed;
}
