/* A lag under a position loop, tick by tick: the same answers as `motion.follow`.

   Nothing but the loop: nothing is checked, and what `follow` says besides of the run (whether the
   loop is stable, which ticks were limited) isn't computed. */

#include <math.h>

typedef struct {
    double gain, growth, share, count, limit;
    long delay;
} Control;

static double nearest(double number)
{
    return fabs(number) < 4.5e15 ? floor(number + 0.5) : number;
}

/* rows: (2, 3) of the next state by angle, rate and command; memory: (1 + delay,) zeros;
   states: (ticks + 1, 2), the first given; commands: (ticks,). */
void run_lag(const double *rows, double steady, const Control *control, double *memory,
             const double *setvalues, const double *slopes, long ticks, double *states,
             double *commands)
{
    double angle = states[0], rate = states[1];
    const double *a = rows, *b = rows + 3;
    for (long tick = 0; tick < ticks; tick++) {
        double position = angle;
        if (control->count > 0) position = control->count * nearest(position / control->count);
        double error = setvalues[tick] - position;
        double u = (control->gain * error + memory[0] + control->share * slopes[tick]) / steady;
        if (u > control->limit) u = control->limit;
        else if (u < -control->limit) u = -control->limit;
        else memory[0] += control->growth * error;
        if (control->delay > 0) {
            double *place = memory + 1 + tick % control->delay, waited = *place;
            *place = u;
            u = waited;
        }
        commands[tick] = u;
        double next = a[0] * angle + a[1] * rate + a[2] * u;
        rate = b[0] * angle + b[1] * rate + b[2] * u;
        angle = next;
        states[2 * tick + 2] = angle;
        states[2 * tick + 3] = rate;
    }
}
