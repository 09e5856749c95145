/* Shortest geodesics on the working sheet, with the answers of geodesic_inverse: a bound.

   The same quadrature and the same search, nodes side by side so that the compiler takes several at
   once. Nothing but the search: no end on one meridian or on the equator, no ring, no check. */

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { FIFTHS = 13, MOST = 48 };

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

typedef struct { double c, A, B, first, cosine, across, along, dc, dB, dfirst, dlast, cos_a, cos_b; } Way;

static Way outer(double r, double R, double sa, double sb, double apart, double rho_a,
                 double rho_b, double X, double u)
{
    double x = u, gap = X - u, dx = 1;
    if (u > 0) {
        double grown = growth(fmin(2 * u / X, 60.0));
        x = X * (grown / (2 + grown));
        gap = 2 * X / (2 + grown);
        dx = gap * (X + x) / (X * X);
    }
    double e = gap * (X + x), W = sqrt(fmax(apart + x * x, 0.0)), k2 = sa * sa + x * x, k = sqrt(k2);
    Way way;
    way.c = 2 * R * e;
    way.A = e + (R - r) / (2 * R);
    way.B = k2;
    way.first = -x / k;
    way.cosine = sa / k;
    way.across = (x * sb < 0 ? apart * k2 / (W * sa - x * sb) : W * sa + x * sb) / k2;
    way.along = (sa * sb - W * x) / k2;
    way.dB = 2 * x * dx;
    way.dc = -2 * R * way.dB;
    way.dfirst = -sa * dx / k2;
    way.dlast = sb * x * dx / (W * k2);
    way.cos_a = x * sqrt(2 * R * (rho_a + way.c)) / rho_a;
    way.cos_b = -W * sqrt(2 * R * (rho_b + way.c)) / rho_b;
    return way;
}

static double rate_of_turn(double R, const Way *way, double sine)
{
    double sin2 = sine * sine, rho = way->c + 2 * R * way->B * sin2;
    return way->c / rho * sqrt(2 * R / ((rho + way->c) * (way->A + way->B * sin2)));
}

static void integrate(double R, const Way *way, const double *nodes, const int64_t *counts, double *sums)
{
    double tangent = way->first / (1 + way->cosine);
    double first = tangent / (1 + sqrt(1 + tangent * tangent));
    double longer = sqrt((1 + fabs(way->along)) / 2), shorter = way->across / (2 * longer);
    double reach = way->along > 0 ? shorter / (1 + longer) : longer / (1 + shorter);
    double grow = reach * (1 + first * first) / (1 - first * reach), last = first + grow;
    double narrow = fmin(way->A, way->c / (2 * R)) / way->B;
    double half = sqrt(narrow) / (1 + sqrt(1 + narrow));
    double peak = half / (1 + sqrt((1 - half) * (1 + half))), past = fmax(first, 0.0);
    double a0 = sqrt(peak * peak + past * past), x = first / a0, z = last / a0;
    double root_x = sqrt(1 + x * x), root_z = sqrt(1 + z * z);
    double sine = x > 0 ? grow / a0 * (x + z) / (z * root_x + x * root_z) : z * root_x - x * root_z;
    double lead = x > 0 ? x + root_x : 1 / (root_x - x), end = z + root_z;
    double width = asinh(sine), size = a0 / 2;
    int which = 5 * width < FIFTHS ? (int)(5 * width) : FIFTHS;
    const double *share = nodes + 2 * MOST * which, *weight = share + MOST;
    int places = (int)counts[2 * which], count = (int)counts[2 * which + 1];
    double turned[MOST], rate[MOST], length[MOST];
    for (int k = 0; k < places; k++) {
        double grown = 1 + growth(width * share[k]), shrunk = 1 / grown;
        double step = weight[k] * (width * size);
        double sum[3] = {0, 0, 0};
        for (int side = 0; side < 2; side++) {
            double up = side ? end * shrunk : lead * grown, down = side ? grown / end : shrunk / lead;
            double v = size * (up - down), v2 = v * v, below = 1 / (1 + v2);
            double s = 4 * v * (1 - v2) * (below * below), sin2 = s * s;
            double rho = way->c + 2 * R * way->B * sin2, both = rho + way->c;
            double D = way->A + way->B * sin2, all = 1 / (rho * (both * D)), by_rho = all * (both * D);
            double density = sqrt(2 * R * (all * rho)) * (4 * (step * (up + down)) * below);
            double drho = way->dc + 2 * R * way->dB * sin2, dD = way->dB * (sin2 - 1);
            double spread = drho * by_rho + (drho + way->dc) / 2 * (all * (rho * D))
                            + dD / 2 * (all * (rho * both));
            sum[0] += way->c * by_rho * density;
            sum[1] += (way->dc - way->c * spread) * by_rho * density;
            sum[2] += rho * density;
        }
        turned[k] = sum[0];
        rate[k] = sum[1];
        length[k] = sum[2];
    }
    sums[0] = sums[1] = sums[2] = 0;
    for (int k = 0; k < count; k++) {
        sums[0] += turned[k];
        sums[1] += rate[k];
        sums[2] += length[k];
    }
    double sine_last = way->first * way->along + way->cosine * way->across;
    sums[1] += way->dlast * rate_of_turn(R, way, sine_last) - way->dfirst * rate_of_turn(R, way, way->first);
}

/* p and q are (n, 2), nodes (FIFTHS + 1, 2, MOST) and counts (FIFTHS + 1, 2) as of `quadratures`,
   found (4, n): length, both azimuths, c. Returns how many pairs took no answer. */
long geodesic_sheet(double r, double R, const double *p, const double *q, long n, const double *nodes,
                    const int64_t *counts, double *found)
{
    long failed = 0;
    for (long i = 0; i < n; i++) {
        double phi1 = p[2 * i + 1], phi2 = q[2 * i + 1], turn = q[2 * i] - p[2 * i];
        int swap = fabs(phi2) > fabs(phi1);
        double a = swap ? phi2 : phi1, b = swap ? phi1 : phi2, mirror = a < 0 ? -1 : 1;
        a *= mirror;
        b *= mirror;
        double angle = fabs(turn), side = turn < 0 ? -1 : 1;
        double sa = sin(a / 2), sb = sin(b / 2), sine = sin((a - b) / 2), cosine = cos((a - b) / 2);
        double apart = sin((a + b) / 2) * sine;
        double rho_a = r + R * cos(a), rho_b = r + R * cos(b), X = sqrt(rho_a / (2 * R));
        double half = sin(angle / 2), other = cos(angle / 2);
        double up = 2 * (rho_b * half * half * 2 * sa * cos(a / 2) - R * sine * cosine);
        double along = 2 * rho_b * fabs(half * other), size = sqrt(up * up + along * along);
        double x = up / size * rho_a / sqrt(2 * R * rho_a * (1 + along / size));
        double u = x > 0 ? X * atanh(fmin(x / X, 0.95)) : 0.99 * x, scale = b <= 0 ? sa : 1e-7;
        double low = -X, high = INFINITY, total = NAN;
        int done = 0;
        Way way = {0};
        for (int round = 0; round < 100; round++) {
            double sums[3];
            way = outer(r, R, sa, sb, apart, rho_a, rho_b, X, u);
            if (done) break;
            integrate(R, &way, nodes, counts, sums);
            double miss = angle - sums[0], step = miss / sums[1];
            if (miss > 0) low = u;
            if (miss < 0) high = u;
            int sound = low <= u + step && u + step <= high;
            done = sound && fabs(step) <= 1e-8 * (fabs(u) + scale) && fabs(miss) < 1e-5;
            total = sums[2] + way.c * miss;
            u = sound ? u + step : isinf(high) ? 2 * fabs(u) + 0.5 : (low + high) / 2;
        }
        failed += !done;
        double back = swap ? -mirror : mirror;
        double first = atan2(side * way.c / rho_a, back * way.cos_a);
        double last = atan2(side * way.c / rho_b, back * way.cos_b);
        found[i] = total;
        found[n + i] = swap ? last : first;
        found[2 * n + i] = swap ? first : last;
        found[3 * n + i] = side * way.c;
    }
    return failed;
}
