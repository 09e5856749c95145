/* What a ball sweeps, cut from intervals on rays: the same answers as DexelGrid.cut_path.

   The same way as the library's: moves in groups, lines side by side without branches, so that the
   compiler takes several at once. Nothing but the loops: no slot is added, nothing is checked. */

#include <math.h>

enum { GROUP = 8, ROW = 4096 };

static double greater(double a, double b) { return a >= b ? a : b; }
static double lesser(double a, double b) { return a <= b ? a : b; }
static double within(double t) { return lesser(greater(t, 0.0), 1.0); }

typedef struct { long first, last, start, stop; } Window;

static long below(const double *values, long count, double value, int past)
{
    long low = 0, high = count;
    while (low < high) {
        long middle = (low + high) / 2;
        if (values[middle] < value || (past && values[middle] == value)) low = middle + 1;
        else high = middle;
    }
    return low;
}

static void turn(double angle, double half, long m, Window *window)
{
    double step = 2 * M_PI / m;
    window->start = (long)ceil((angle - half) / step - 0.5 - 1e-9);
    window->stop = (long)floor((angle + half) / step - 0.5 + 1e-9) + 1;
    if (window->stop > window->start + m) window->stop = window->start + m;
}

static Window window_of(const double *a, const double *b, double radius, const double *x, long n,
                        long m, const double *nearest)
{
    Window window;
    double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    double reach = radius + sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / 2;
    double cx = (a[0] + b[0]) / 2, cy = (a[1] + b[1]) / 2, cz = (a[2] + b[2]) / 2;
    double off = hypot(cy, cz), angle = atan2(cz, cy);
    double half = off > reach ? asin(reach / off) : M_PI;
    turn(angle, half, m, &window);
    double inner = INFINITY;
    for (long j = window.start; j < window.stop; j++) inner = lesser(inner, nearest[(j + m) % m]);
    if (inner * inner > off * off - reach * reach && off > 0 && inner > 0 && inner < INFINITY)
        half = acos(lesser(greater((inner * inner + off * off - reach * reach) / (2 * off * inner),
                                   -1.0), 1.0));
    double gap = greater(inner - off, 0.0);
    double width = inner - off > reach ? -1.0 : sqrt(greater(reach * reach - gap * gap, 0.0));
    window.first = below(x, n, cx - width, 0);
    window.last = below(x, n, cx + width, 1);
    turn(angle, half, m, &window);
    return window;
}

/* One axis as the rays of one angle see it. */
static double sx[GROUP][ROW], side[GROUP][ROW], fx[GROUP][ROW], fy[GROUP][ROW], run[GROUP][ROW];
static double rise[GROUP][ROW], start[GROUP][ROW], size[GROUP];
static double enter[GROUP][ROW], leave[GROUP][ROW], near[ROW], far[ROW];
static unsigned char reached[ROW];

static void see(const double *a, const double *b, long k, long width, const double *c,
                const double *s)
{
    double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    size[k] = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (size[k] == 0) size[k] = 1.0;
    for (long j = 0; j < width; j++) {
        int turned = c[j] * d[1] + s[j] * d[2] < 0;
        const double *p = turned ? b : a, *q = turned ? a : b;
        double vx = q[0] - p[0], vy = q[1] - p[1], vz = q[2] - p[2];
        double across = s[j] * vy - c[j] * vz;
        run[k][j] = hypot(vx, across);
        double pace = run[k][j] > 0 ? run[k][j] : 1.0;
        rise[k][j] = c[j] * vy + s[j] * vz;
        fx[k][j] = run[k][j] > 0 ? vx / pace : 1.0;
        fy[k][j] = across / pace;
        sx[k][j] = p[0];
        side[k][j] = s[j] * p[1] - c[j] * p[2];
        start[k][j] = c[j] * p[1] + s[j] * p[2];
    }
}

static void meet(double x, double radius, long k, long begin, long end)
{
    for (long j = begin; j < end; j++) {
        double qx = x - sx[k][j], qy = 0.0 - side[k][j];
        double s = qx * fy[k][j] - fx[k][j] * qy, m = qx * fx[k][j] + qy * fy[k][j];
        double room = (radius - s) * (radius + s);
        double h = rise[k][j] / size[k] * sqrt(greater(room, 0.0));
        int still = run[k][j] == 0;
        double pace = still ? 1.0 : run[k][j];
        double first = within((m - h) / pace), last = within((m + h) / pace);
        first = still ? 0.0 : first;
        last = still ? 1.0 : last;
        double behind = m - first * run[k][j], ahead = m - last * run[k][j];
        double before = room - behind * behind, after = room - ahead * ahead;
        double in = first * rise[k][j] - sqrt(greater(before, 0.0));
        double out = last * rise[k][j] + sqrt(greater(after, 0.0));
        enter[k][j] = before > 0 ? in + start[k][j] : INFINITY;
        leave[k][j] = before > 0 ? out + start[k][j] : -INFINITY;
    }
}

static double take(double *low, double *high, long slots, long every, double first, double last,
                   double cell)
{
    double removed = 0.0;
    for (long slot = 0; slot < slots; slot++) {
        double begins = low[slot * every], ends = high[slot * every];
        if (!(last > begins && first < ends && first < last && begins < ends)) continue;
        double from = greater(begins, first), to = lesser(ends, last);
        removed += cell * (to - from) * ((to + from) / 2);
        if (first > begins) high[slot * every] = first;
        else low[slot * every] = last < ends ? last : ends;
        if (first > begins && last < ends) {
            long free = 0;
            while (free < slots && high[free * every] > low[free * every]) free++;
            if (free == slots) return NAN;
            low[free * every] = last;
            high[free * every] = ends;
        }
    }
    return removed;
}

/* Cut moves through centres (moves + 1, 3) from low, high (slots, n, m); return the volume, or not a
   number where no slot is free. */
double cut_path(const double *centres, long moves, double radius, long n, long m, long slots,
                double *low, double *high, const double *x, const double *cs, const double *sn,
                const double *nearest, double cell)
{
    double removed = 0.0;
    for (long here = 0; here < moves; here += GROUP) {
        long k, count = moves - here < GROUP ? moves - here : GROUP, filled = 0;
        const double *a = centres + 3 * here, *b = a + 3 * count;
        Window all = {n, 0, 0, 0};
        for (k = 0; k < count; k++) {
            Window one = window_of(a + 3 * k, a + 3 * k + 3, radius, x, n, m, nearest);
            if (one.first >= one.last || one.start >= one.stop) continue;
            if (!filled++) all = one;
            long shift = ((one.start - all.start + m / 2) % m + m) % m - m / 2 + all.start - one.start;
            all.first = one.first < all.first ? one.first : all.first;
            all.last = one.last > all.last ? one.last : all.last;
            all.stop = one.stop + shift > all.stop ? one.stop + shift : all.stop;
            all.start = one.start + shift < all.start ? one.start + shift : all.start;
        }
        if (!filled) continue;
        if (all.stop > all.start + m) all.stop = all.start + m;
        double cx = (a[0] + b[0]) / 2, cy = (a[1] + b[1]) / 2, cz = (a[2] + b[2]) / 2, about = 0.0;
        for (k = 0; k <= count; k++) {
            double d[3] = {a[3 * k] - cx, a[3 * k + 1] - cy, a[3 * k + 2] - cz};
            about = greater(about, sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
        }
        about = (radius + about) * (1 + 1e-9);
        all.stop -= all.start;
        all.start = (all.start % m + m) % m;
        all.stop += all.start;
        for (int part = 0; part < 2; part++) {
            long left = part ? 0 : all.start;
            long width = (part ? all.stop - m : all.stop < m ? all.stop : m) - left;
            if (width <= 0) continue;
            const double *c = cs + left, *s = sn + left;
            for (k = 0; k < count; k++) see(a + 3 * k, a + 3 * k + 3, k, width, c, s);
            for (long i = all.first; i < all.last; i++) {
                double *bottom = low + i * m + left, *top = high + i * m + left, off = x[i] - cx;
                for (long j = 0; j < width; j++) {
                    double beside = 0.0 - (s[j] * cy - c[j] * cz);
                    double half = sqrt(greater(about * about - off * off - beside * beside, 0.0));
                    double middle = c[j] * cy + s[j] * cz;
                    near[j] = middle - half;
                    far[j] = middle + half;
                    reached[j] = 0;
                }
                for (long slot = 0; slot < slots; slot++) {
                    const double *lows = bottom + slot * n * m, *highs = top + slot * n * m;
                    for (long j = 0; j < width; j++)
                        reached[j] |= (near[j] < highs[j]) & (far[j] > lows[j]) & (lows[j] < highs[j]);
                }
                long begin = 0, end = width;
                while (begin < width && !reached[begin]) begin++;
                while (end > begin && !reached[end - 1]) end--;
                for (k = 0; k < count; k++) meet(x[i], radius, k, begin, end);
                for (long j = begin; j < end; j++) {
                    if (!reached[j]) continue;
                    double first = INFINITY, last = -INFINITY;
                    for (k = 0; k < count; k++) {
                        double in = enter[k][j], out = leave[k][j];
                        if (in < out && first < last && (in > last || out < first)) {
                            removed += take(bottom + j, top + j, slots, n * m, first, last, cell);
                            first = INFINITY;
                            last = -INFINITY;
                        }
                        first = lesser(first, in);
                        last = greater(last, out);
                    }
                    removed += take(bottom + j, top + j, slots, n * m, first, last, cell);
                }
            }
        }
    }
    return removed;
}
