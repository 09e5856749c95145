/* The cones at points by their forms: the same answers as cone_loops.fill_cones, to the last bit.

   The same way as the library's, written for it: arrays in place of tuples, no copies. */

#include <math.h>

enum { SHAPE = 26, STEPS = 100 };
static const double SAME = 2e-5, FAR = 14.0, NEAR = 1e-9, VANISHES = 1e-12;

typedef struct { double x; int crosses; } Place;

static double sum_at(const double *a, const double *b, double c, double s)
{
    double three = ((a[0] * c + a[1] * s) * c + a[2] * s * s) * c + a[3] * s * s * s;
    return three + ((b[0] * c + b[1] * s) * c + b[2] * s * s);
}

static void product(const double *p, const double *q, double *out)
{
    out[0] = p[0] * q[0];
    out[1] = p[0] * q[1] + p[1] * q[0];
    out[2] = p[1] * q[1];
}

static void add_product(double *z, double p0, double p1, const double *q)
{
    z[0] = z[0] + p0 * q[0];
    z[1] = z[1] + (p0 * q[1] + p1 * q[0]);
    z[2] = z[2] + (p0 * q[2] + p1 * q[1]);
    z[3] = z[3] + p1 * q[2];
}

static void on_a_line(const double *cubic, const double *square, double c, double s, double *p)
{
    double h[2] = {c, -s}, k[2] = {s, c}, hh[3], hk[3], kk[3], three[4], two[3];
    product(h, h, hh);
    product(h, k, hk);
    product(k, k, kk);
    for (int i = 0; i < 4; i++) three[i] = 0.0 * cubic[0];
    add_product(three, cubic[0] * h[0] + cubic[1] * k[0], cubic[0] * h[1] + cubic[1] * k[1], hh);
    add_product(three, cubic[2] * h[0] + cubic[3] * k[0], cubic[2] * h[1] + cubic[3] * k[1], kk);
    for (int i = 0; i < 3; i++)
        two[i] = square[0] * hh[i] + square[1] * hk[i] + square[2] * kk[i];
    p[0] = two[0] + three[0];
    p[1] = 2 * (two[1] + three[1]);
    p[2] = 4 * (two[2] + three[2]) - (two[0] + 3 * three[0]);
    p[3] = 8 * three[3] - 4 * three[1];
    p[4] = 4 * (two[2] - three[2]) - (two[0] - 3 * three[0]);
    p[5] = 2 * (three[1] - two[1]);
    p[6] = two[0] - three[0];
}

static double value(const double *p, double x)
{
    return (((((p[6] * x + p[5]) * x + p[4]) * x + p[3]) * x + p[2]) * x + p[1]) * x + p[0];
}

static Place zero(const double *p, const double *slope, double low, double high)
{
    double at_low = value(p, low), at_high = value(p, high);
    int below = at_low < 0;
    if (below == (at_high < 0))
        return (Place){fabs(at_high) < fabs(at_low) ? high : low, 0};
    double x = 0.5 * (low + high);
    for (int i = 0; i < STEPS; i++) {
        double y = value(p, x);
        if (below == (y < 0)) low = x; else high = x;
        double after = x - y / value(slope, x);
        if (!(low <= after && after <= high)) after = 0.5 * (low + high);
        int far = fabs(after - x) > NEAR * (1 + fabs(x));
        x = after;
        if (!far) break;
    }
    return (Place){x, 1};
}

static void order_four(const double *f2, const double *f3, const double *f4, double rho,
                       double floor, double *cone)
{
    double c = cone[0], s = cone[1];
    double fee = 2 * ((f2[0] * c + f2[1] * s) * c + f2[2] * s * s);
    double fww = 2 * ((f2[0] * s - f2[1] * c) * s + f2[2] * c * c);
    double by_c = (3 * f3[0] * c + 2 * f3[1] * s) * c + f3[2] * s * s;
    double by_s = (f3[1] * c + 2 * f3[2] * s) * c + 3 * f3[3] * s * s;
    double feew = 2 * (c * by_s - s * by_c);
    double feeee = 24 * ((((f4[0] * c + f4[1] * s) * c + f4[2] * s * s) * c + f4[3] * s * s * s) * c
                         + f4[4] * s * s * s * s);
    double four = rho * rho * feeee, three = 6 * rho * feew, two = 3 * (fww - fee);
    double total = fabs(four) + fabs(three) + fabs(two);
    if (!(total > floor)) total = floor;
    cone[3] = fee;
    cone[4] = (four + three + two) / (total + (total == 0));
}

static void cones_of(const double *shape, double rho, const double *cosines, const double *sines,
                     double *cones)
{
    const double *f2 = shape + 14, *f3 = shape + 17, *f4 = shape + 21;
    double cubic[4], across[3] = {3 * f2[1], 6 * (f2[2] - f2[0]), -3 * f2[1]};
    for (int i = 0; i < 4; i++) cubic[i] = 6 * rho * f3[i];
    double norm2 = sqrt(4 * f2[0] * f2[0] + 2 * f2[1] * f2[1] + 4 * f2[2] * f2[2]);
    double three = rho * sqrt(36 * (f3[0] * f3[0] + f3[3] * f3[3])
                              + 12 * (f3[1] * f3[1] + f3[2] * f3[2]));
    double norm4 = sqrt(576 * (f4[0] * f4[0] + f4[4] * f4[4])
                        + 144 * (f4[1] * f4[1] + f4[3] * f4[3]) + 96 * f4[2] * f4[2]);
    double two = 3 * norm2, floor = 1e-3 * (rho * rho * norm4 + 6 * three + two);
    double greatest = -1.0, at_c = 0.0, at_s = 0.0;
    for (int j = 0; j < 7; j++) {
        double size = fabs(sum_at(cubic, across, cosines[j], sines[j]));
        if (size > greatest) { greatest = size; at_c = -cosines[j]; at_s = -sines[j]; }
    }
    double every[7][7];
    on_a_line(cubic, across, at_c, at_s, every[0]);
    for (int k = 1; k < 7; k++) {
        for (int i = 0; i < 6; i++) every[k][i] = (i + 1) * every[k - 1][i + 1];
        every[k][6] = 0.0 * every[k - 1][6];
    }
    Place ends[6];
    for (int i = 0; i < 6; i++) ends[i] = (Place){FAR, 0};
    for (int k = 5; k >= 0; k--) {
        double low = -FAR;
        for (int i = 0; i < 6; i++) {
            double high = i < 5 ? ends[i].x : FAR;
            ends[i] = zero(every[k], every[k + 1], low, high);
            low = high;
        }
    }
    double last = -2 * FAR;
    for (int i = 0; i < 6; i++) {
        double x = ends[i].x, reach = 0.5 * SAME * (1 + x * x), factor = 1.0, step = 0.0;
        double before = value(every[0], x), most = fabs(before), *cone = cones + 5 * i;
        int m = 0;
        for (int k = 1; k < 7; k++) {
            factor = factor * reach / k;
            double here = value(every[k], x), size = fabs(here) * factor;
            if (size > most) { most = size; m = k; step = before / here; }
            before = here;
        }
        x = x - step;
        int is_zero = (ends[i].crosses && m > 0) || m > 1;
        cone[2] = is_zero && x - last > reach && !(greatest <= VANISHES * (three + two)) ? m : 0;
        if (is_zero) last = x;
        double inverse = 1 / (1 + x * x), c = (1 - x * x) * inverse, s = 2 * x * inverse;
        cone[0] = at_c * c - at_s * s;
        cone[1] = at_s * c + at_c * s;
        order_four(f2, f3, f4, rho, floor, cone);
    }
}

void fill_cones(const double *shapes, long count, double rho, const double *cosines,
                const double *sines, double *cones)
{
    for (long i = 0; i < count; i++)
        cones_of(shapes + i * SHAPE, rho, cosines, sines, cones + 30 * i);
}
