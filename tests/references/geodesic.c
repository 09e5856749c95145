/* Waypoints between two joint positions of a torus, for a small controller: on the projected chord
 * ("tangent spheres") and, in three ways, on the geodesic. controller_cycles.py measures them.
 *
 * Of arc measured from 0 at P to 1 at Q, Clairaut's G = rho^2 theta' is constant, and
 * phi'' = -(G^2 / R) sin(phi) / rho^3. The length needs no equation of its own: it comes with G.
 */
#include <math.h>

#define COUNT 9.58738e-5  /* rad, of 2^16 a turn */
#define NEAR (0.1 * COUNT)
enum { TRIES = 12 };

/* Equal steps along the chord, each brought to its foot. */
void chord(double ring, double tube, double thetaP, double phiP, double thetaQ, double phiQ,
    int points, double *theta, double *phi)
{
    double rhoP = ring + tube * cos(phiP), rhoQ = ring + tube * cos(phiQ);
    double x = rhoP * cos(thetaP), y = tube * sin(phiP), z = -rhoP * sin(thetaP);
    double part = 1.0 / (points - 1);
    double dx = part * (rhoQ * cos(thetaQ) - x), dy = part * (tube * sin(phiQ) - y);
    double dz = part * (-rhoQ * sin(thetaQ) - z);
    for (int i = 0; i < points; ++i) {
        theta[i] = atan2(-z, x);
        phi[i] = atan2(y, sqrt(x * x + z * z) - ring);
        x += dx;
        y += dy;
        z += dz;
    }
}

/* By shooting. A waypoint is a step of Nystroem's method of fourth order, which is Runge and Kutta's
 * where phi'' depends on phi alone, with three places a step; theta gets Simpson's rule from them.
 * Broyden's secants correct phi' at P and G: on short ways Q moves almost as without the torus' bend,
 * which gives the first ones. Returns the shots, or 0 where TRIES of them don't meet Q.
 */
static void bend(double ring, double tube, double phi, double *bends, double *turns)
{
    double near = 1.0 / (ring + tube * cos(phi));
    *turns = near * near;
    *bends = sin(phi) * near * *turns;
}

int geodesic(double ring, double tube, double thetaP, double phiP, double thetaQ, double phiQ,
    int points, double *theta, double *phi)
{
    double turn = thetaQ - thetaP, h = 1.0 / (points - 1);
    double sinP = sin(phiP), cosP = cos(phiP);
    double rhoP = ring + tube * cosP, rhoQ = ring + tube * cos(phiQ);
    /* The chord seen from P: outwards from the axis, up, and towards growing theta. */
    double outP = rhoQ * cos(turn) - rhoP, upP = tube * (sin(phiQ) - sinP), overP = rhoQ * sin(turn);
    double square = outP * outP + upP * upP + overP * overP;
    double normal = outP * cosP + upP * sinP;
    /* Its share in the tangent plane is shorter than an arc of a circle by this factor. */
    double longer = square > 0 ? 1.0 + 2.0 / 3.0 * normal * normal / square : 1.0;
    double slope = longer * (upP * cosP - outP * sinP) / tube, G = longer * rhoP * overP;
    double a = 1.0, b = 0.0, c = 0.0, d = rhoP * rhoQ;  /* (slope, G) by what Q misses */
    double moved = 0.0, grown = 0.0, missedPhi = 0.0, missedTheta = 0.0;

    for (int shot = 1; shot <= TRIES; ++shot) {
        double v = slope * h, k = -G * G * h * h / tube, along = G * h / 6.0;
        double half = 0.5 * k, eighth = 0.125 * k, sixth = k / 6.0, f1, f2, f3, g1, g2, g3;
        theta[0] = thetaP;
        phi[0] = phiP;
        for (int i = 0; i < points - 1; ++i) {
            double at = phi[i];
            bend(ring, tube, at, &f1, &g1);
            bend(ring, tube, at + 0.5 * v + eighth * f1, &f2, &g2);
            bend(ring, tube, at + v + half * f2, &f3, &g3);
            theta[i + 1] = theta[i] + along * (g1 + 4.0 * g2 + g3);
            phi[i + 1] = at + v + sixth * (f1 + 2.0 * f2);
            v += sixth * (f1 + 4.0 * f2 + f3);
        }
        double missPhi = phiQ - phi[points - 1], missTheta = thetaQ - theta[points - 1];
        if (fabs(missPhi) <= NEAR && fabs(missTheta) <= NEAR) return shot;
        if (shot > 1) {
            double y = missedPhi - missPhi, z = missedTheta - missTheta;  /* what the step did to Q */
            double p = a * y + b * z, q = c * y + d * z;
            double scale = 1.0 / (moved * p + grown * q);
            double s = (moved * a + grown * c) * scale, t = (moved * b + grown * d) * scale;
            a += (moved - p) * s;
            b += (moved - p) * t;
            c += (grown - q) * s;
            d += (grown - q) * t;
        }
        moved = a * missPhi + b * missTheta;
        grown = c * missPhi + d * missTheta;
        slope += moved;
        G += grown;
        missedPhi = missPhi;
        missedTheta = missTheta;
    }
    return 0;
}

/* By Newton's method on all waypoints and G at once, from even steps of both angles. Numerov's method
 * ties each waypoint to its neighbours, and Gregory's rule, of the same order, turns theta: from 7
 * points on. With 9 points the widest ways within the reference machine's joint limits are off by
 * 1.6 counts, by shooting 0.2. Returns the sweeps, or 0 where TRIES of them don't settle.
 */
int geodesic_relaxed(double ring, double tube, double thetaP, double phiP, double thetaQ,
    double phiQ, int points, double *theta, double *phi)
{
    static const double ends[] = {8.0 / 24.0, 31.0 / 24.0, 20.0 / 24.0, 25.0 / 24.0};
    int last = points - 1, sweep = 0;
    double bends[points], steep[points], turns[points];  /* sin(phi) / rho^3, its slope, 1 / rho^2 */
    double pivot[points], a[points], b[points];  /* a step of phi is a + dG b */
    double h = 1.0 / last, G = (ring + tube * cos(phiP)) * (ring + tube * cos(phiQ)), most;
    G *= thetaQ - thetaP;
    for (int i = 0; i <= last; ++i) phi[i] = phiP + i * h * (phiQ - phiP);
    phi[last] = phiQ;

    do {
        double k = G * h * h / (12.0 * tube), kG = k * G, length = 0.0, wider = 0.0, more = 0.0;
        if (++sweep > TRIES) return 0;
        for (int i = 0; i <= last; ++i) {
            if (sweep == 1 || (0 < i && i < last)) {
                double sine = sin(phi[i]), cosine = cos(phi[i]), near = 1.0 / (ring + tube * cosine);
                double cube = near * near * near;
                turns[i] = near * near;
                bends[i] = sine * cube;
                steep[i] = cube * (cosine + 3.0 * tube * sine * sine * near);
            }
        }
        pivot[0] = a[0] = b[0] = a[last] = b[last] = 0.0;
        for (int i = 1; i < last; ++i) {
            double below = 1.0 + kG * steep[i - 1], own = 1.0 + kG * steep[i];
            double pull = bends[i - 1] + 10.0 * bends[i] + bends[i + 1];
            double miss = phi[i - 1] - 2.0 * phi[i] + phi[i + 1] + kG * pull;
            pivot[i] = 1.0 / (10.0 * own - 12.0 - (i > 1 ? below * own * pivot[i - 1] : 0.0));
            a[i] = (-miss - below * a[i - 1]) * pivot[i];
            b[i] = (-2.0 * k * pull - below * b[i - 1]) * pivot[i];
        }
        for (int i = last - 1; i > 0; --i) {
            double above = (1.0 + kG * steep[i + 1]) * pivot[i];
            a[i] -= above * a[i + 1];
            b[i] -= above * b[i + 1];
        }
        for (int i = 0; i <= last; ++i) {
            int end = i < last - i ? i : last - i;
            double weight = end < 4 ? ends[end] : 1.0;
            length += weight * turns[i];
            wider += weight * bends[i] * a[i];
            more += weight * bends[i] * b[i];
        }
        wider = length + 2.0 * tube * wider;
        double dG = (thetaQ - thetaP - G * h * wider) / (h * (length + 2.0 * tube * G * more));
        most = fabs(dG) * h * length;
        for (int i = 1; i < last; ++i) {
            double step = a[i] + dG * b[i];
            phi[i] += step;
            turns[i] += 2.0 * tube * bends[i] * step;
            most = fmax(most, fabs(step));
        }
        G += dG;
    } while (most > NEAR);

    h *= G / 24.0;
    theta[0] = thetaP;
    for (int i = 0; i < last; ++i) {
        const double *g = turns + i;
        double over;
        if (i == 0)
            over = 9.0 * g[0] + 19.0 * g[1] - 5.0 * g[2] + g[3];
        else if (i == last - 1)
            over = 9.0 * g[1] + 19.0 * g[0] - 5.0 * g[-1] + g[-2];
        else
            over = 13.0 * (g[0] + g[1]) - g[-1] - g[2];
        theta[i + 1] = theta[i] + h * over;
    }
    return sweep;
}

/* As in a textbook: angles and azimuth by Runge and Kutta in arc length, a waypoint a step; Newton's
 * method for azimuth and length, whose derivatives are differences of two more shots. Returns the
 * rounds of three shots, or 0 where TRIES of them don't meet Q.
 */
static void slopes(double ring, double tube, const double at[3], double by[3])
{
    double near = 1.0 / (ring + tube * cos(at[1]));
    by[0] = sin(at[2]) * near;
    by[1] = cos(at[2]) / tube;
    by[2] = sin(at[1]) * by[0];
}

static void shoot(double ring, double tube, double azimuth, double length, int points,
    double *theta, double *phi)
{
    double h = length / (points - 1), at[3] = {theta[0], phi[0], azimuth}, k[4][3], next[3];
    for (int i = 1; i < points; ++i) {
        slopes(ring, tube, at, k[0]);
        for (int stage = 1; stage < 4; ++stage) {
            double part = stage < 3 ? 0.5 * h : h;
            for (int j = 0; j < 3; ++j) next[j] = at[j] + part * k[stage - 1][j];
            slopes(ring, tube, next, k[stage]);
        }
        for (int j = 0; j < 3; ++j)
            at[j] += h / 6.0 * (k[0][j] + 2.0 * (k[1][j] + k[2][j]) + k[3][j]);
        theta[i] = at[0];
        phi[i] = at[1];
    }
}

int geodesic_textbook(double ring, double tube, double thetaP, double phiP, double thetaQ,
    double phiQ, int points, double *theta, double *phi)
{
    double turn = thetaQ - thetaP, rhoP = ring + tube * cos(phiP), rhoQ = ring + tube * cos(phiQ);
    double out = rhoQ * cos(turn) - rhoP, up = tube * (sin(phiQ) - sin(phiP));
    double over = rhoQ * sin(turn), little = 1e-3;
    double azimuth = atan2(over, up * cos(phiP) - out * sin(phiP));
    double length = sqrt(out * out + up * up + over * over);
    double *lastTheta = theta + points - 1, *lastPhi = phi + points - 1;

    theta[0] = thetaP;
    phi[0] = phiP;
    for (int round = 1; round <= TRIES; ++round) {
        shoot(ring, tube, azimuth + little, length, points, theta, phi);
        double a = *lastTheta, b = *lastPhi;
        shoot(ring, tube, azimuth, length + little, points, theta, phi);
        double c = *lastTheta, d = *lastPhi;
        shoot(ring, tube, azimuth, length, points, theta, phi);
        double missTheta = thetaQ - *lastTheta, missPhi = phiQ - *lastPhi;
        if (fabs(missTheta) <= NEAR && fabs(missPhi) <= NEAR) return round;
        a -= *lastTheta;
        b -= *lastPhi;
        c -= *lastTheta;
        d -= *lastPhi;
        double scale = little / (a * d - b * c);
        azimuth += (d * missTheta - c * missPhi) * scale;
        length += (a * missPhi - b * missTheta) * scale;
    }
    return 0;
}
