/* Ends of geodesics of given starts on the working sheet, with the answers of geodesic_direct: a bound.

   The same series and the same search, nodes side by side so that the compiler takes several at once.
   Nothing but that: no meridian, no narrow peak, no ring, no way round the tube, no check. */

#include <math.h>

enum { LEVELS = 10, MOST = 64 };

static double series(const double *factors, int terms, double x)
{
    double twice = 2 * cos(2 * x), b = 0, before = 0;
    for (int j = terms - 1; j > 0; j--) {
        double next = (factors[j] - before) + twice * b;
        before = b;
        b = next;
    }
    return factors[0] * x + sin(2 * x) * b;
}

/* start is (3, n): theta, phi, azimuth in rad; length (n) in m; terms and least (LEVELS), squares
   (LEVELS, MOST), matrices (LEVELS, MOST, MOST), found (3, n). Returns how many took no answer. */
long geodesic_direct(double r_in_m, double R, const double *start, const double *length, long n,
                     const double *terms_of, const double *least, const double *squares,
                     const double *matrices, double *found)
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
        double flat = 1 / sqrt(1 + B / fmin(A, c / 2)), k = sqrt(flat);
        int level = 0;
        while (level < LEVELS && flat < least[level]) level++;
        if (level == LEVELS) {
            failed++;
            continue;
        }
        int terms = (int)terms_of[level];
        const double *square = squares + MOST * level, *matrix = matrices + MOST * MOST * level;
        double values[2][MOST], sums[2][MOST];
        for (int j = 0; j < terms; j++) {
            double dt = k / (1 - (1 - flat) * square[j]), sin2 = k * square[j] * dt;
            double here = c + 2 * B * sin2, density = sqrt(2 / ((here + c) * (A + B * sin2))) * dt;
            values[0][j] = here * density;
            values[1][j] = c / here * density;
            sums[0][j] = sums[1][j] = 0;
        }
        for (int one = 0; one < 2; one++)
            for (int m = 0; m < terms; m++)
                for (int j = 0; j < terms; j++) sums[one][j] += matrix[MOST * m + j] * values[one][m];
        double begun = half < 0 ? (slope > 0 ? -1 : 1) : 0;
        double x0 = atan2(half < 0 ? slope : -slope, k * fabs(half)), mean = sums[0][0];
        double rest = length[i] / R + series(sums[0], terms, x0), swings = rint(rest / (M_PI * mean));
        rest -= swings * M_PI * mean;
        double x = rest / mean, last = INFINITY;
        x -= (sums[0][1] + 2 * sums[0][2] * cos(2 * x)) * sin(2 * x)
             / (mean + 2 * sums[0][1] * cos(2 * x) + 4 * sums[0][2] * cos(4 * x));
        for (int round = 0; round < 30 && last > 1e-8; round++) {
            double s = sin(x), dt = k / (1 - (1 - flat) * s * s), sin2 = k * s * s * dt;
            double here = c + 2 * B * sin2, density = sqrt(2 / ((here + c) * (A + B * sin2))) * dt;
            double moved = x + (rest - series(sums[0], terms, x)) / (here * density);
            moved = fmax(-M_PI / 2, fmin(M_PI / 2, moved));
            last = fabs(moved - x);
            x = moved;
        }
        failed += !(last <= 1e-8);
        double turned = series(sums[1], terms, x) - series(sums[1], terms, x0);
        double size = hypot(k * sin(x), cos(x)), s = k * sin(x) / size, here = c + 2 * B * s * s;
        double across = (fmod(swings + begun, 2) == 0 ? 1 : -1) * sqrt(B);
        found[i] = start[i] + side * (turned + swings * M_PI * sums[1][0]);
        found[n + i] = 2 * atan2(across * cos(x) / size, sqrt(A + B * s * s));
        found[2 * n + i] = side * atan2(c / here, -across * s * (sqrt(2 * (here + c)) / here));
    }
    return failed;
}
