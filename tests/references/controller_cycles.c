/* What one call of a controller's parts costs: the firmware that controller_cycles.py measures.
 *
 * SUBJECT is a C text of the library. Where an ATmega's simulator counts cycles the marks go to an
 * I/O register that it watches; on a Cortex-M its timer counts instructions.
 */
#include <math.h>
#include <stdint.h>
#include SUBJECT

enum { EMPTY = 1, LOAD, TICK, TWO, LISTING_LOAD, LISTING, SLOPE_LOAD, SLOPE, SLOW, SCAN, WAYPOINTS,
       PAIRS };

#ifdef __AVR__
#include <avr/io.h>
#include <avr/sleep.h>
static void begin(uint8_t what) { GPIOR0 = what; }
static void end(void) { GPIOR0 = 0; }
static void said(int32_t value)
{
    for (uint8_t k = 0; k < 4; ++k) GPIOR1 = (uint8_t)(value >> (8 * k));
}
static void stop(void) { sleep_enable(); sleep_cpu(); }
#else
#define TIMER ((volatile uint32_t *)0xE000E010)  /* SysTick: control, reload, value */
static uint32_t begun, name;
static void call(int32_t what, const void *with)
{
    register int32_t r0 __asm__("r0") = what;
    register const void *r1 __asm__("r1") = with;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}
static void print(char mark, int32_t value)
{
    char text[14], *at = text + 13;
    uint32_t left = value < 0 ? -(uint32_t)value : (uint32_t)value;
    *at = 0;
    *--at = '\n';
    do { *--at = (char)('0' + left % 10); left /= 10; } while (left);
    if (value < 0) *--at = '-';
    *--at = mark;
    call(4, at);
}
#ifdef WAYS  /* some take more than the timer's 24 bits, whose rounds are counted then */
enum { TIMER_MODE = 7 };
static volatile uint32_t rounds;
static void again(void) { ++rounds; }
static void begin(uint8_t what) { name = what; rounds = 0; begun = TIMER[2]; }
static uint32_t since(uint32_t now) { return (rounds << 24) + begun - now; }
#else
enum { TIMER_MODE = 5 };
static void again(void) {}
static void begin(uint8_t what) { name = what; begun = TIMER[2]; }
static uint32_t since(uint32_t now) { return (begun - now) & 0xFFFFFF; }
#endif
static void end(void)
{
    uint32_t now = TIMER[2];
    print('@', (int32_t)name);
    print('+', (int32_t)since(now));
}
static void said(int32_t value) { print('=', value); }
static void stop(void) { call(0x18, (void *)0x20026); }
#endif

/* Parts aren't inlined, nor is anything of theirs done before or after. */
#define PART __attribute__((noinline, noclone)) static void
static void measured(uint8_t what, void (*volatile part)(void))
{
    begin(what);
    part();
    end();
}

PART empty(void) { __asm__ volatile(""); }

#ifdef LINES
static int32_t start[2], stop_at[2], ticks;
static uint32_t drawn = 2026;

static int32_t random_number(int32_t low, int32_t high)
{
    drawn = drawn * 1664525u + 1013904223u;
    return low + (int32_t)((drawn >> 8) % (uint32_t)(high - low));
}

static FB_Line line[2];
static inline void load_one(int axis)
{
    line[axis].bLoad = true;
    line[axis].nStart = start[axis];
    line[axis].nStop = stop_at[axis];
    line[axis].nTicks = ticks;
    fb_line(&line[axis]);
    line[axis].bLoad = false;
}
PART load(void) { load_one(0); }
PART tick(void) { fb_line(&line[0]); }
PART two(void) { fb_line(&line[0]); fb_line(&line[1]); }

/* The document's listing, statement by statement in its own names, in single precision. */
static float nx, nxi, e, y;
static int32_t setvalue;
PART listing_load(void)
{
    float j = (float)ticks, k = (float)(stop_at[0] - start[0]);
    nx = k / j;
    nxi = floorf(nx);
    e = 0;
    y = (float)start[0];
}
PART listing(void)
{
    if (e > 0.5f) {
        y = y + 1;
        e = e - 1;
    }
    setvalue = (int32_t)y;
    y = y + nxi;
    e = e + nx - nxi;
}

/* A straight line, y = k x + d, in single precision. */
static float slope, first;
static int32_t n;
PART slope_load(void)
{
    slope = (float)(stop_at[0] - start[0]) / (float)ticks;
    first = (float)start[0];
    n = 0;
}
PART straight(void) { setvalue = (int32_t)floorf(slope * (float)n++ + first + 0.5f); }

static void all(void)
{
    for (int move = 0; move < MOVES; ++move) {
        for (int axis = 0; axis < 2; ++axis) {
            start[axis] = random_number(-32768, 32768);
            stop_at[axis] = start[axis] + random_number(-2000, 2000);
        }
        ticks = random_number(2, 40);
        measured(LOAD, load);
        measured(LISTING_LOAD, listing_load);
        measured(SLOPE_LOAD, slope_load);
        for (int32_t k = 0; k <= ticks; ++k) {
            said(line[0].nSet);
            measured(LISTING, listing);
            said(setvalue);
            measured(SLOPE, straight);
            said(setvalue);
            if (k < ticks) measured(TICK, tick);
        }
        for (int axis = 0; axis < 2; ++axis) load_one(axis);
        for (int32_t k = 0; k < ticks; ++k) measured(TWO, two);
        said(line[1].nSet);
    }
}
#endif

#ifdef CONTROLLER
static FB_Setpoints setpoints;
static FB_Tunneller c = FB_TUNNELLER_BEGIN;
static volatile T_Ring ring;
PART slow(void) { fb_setpoints(&setpoints, &ring); }
PART scan(void) { fb_tunneller(&c, &ring); }
static void all(void)
{
    c.nActualTheta = (int32_t)floor(aStart[0] / rCount + 0.5);
    c.nActualPhi = (int32_t)floor(aStart[1] / rCount + 0.5);
    c.bEnable = true;
    scan();
    c.bStart = true;
    scan();
    slow();  /* to the start position */
    while (setpoints.nRow < nRows) {
        measured(SLOW, slow);
        said(setpoints.point.nTheta);
        said(setpoints.point.nPhi);
    }
    while (c.nState == 2) {
        c.nActualTheta = c.nSetTheta;
        c.nActualPhi = c.nSetPhi;
        if (c.nTick < 0) scan();
        else measured(SCAN, scan);
    }
    said(c.bDone);
}
#endif

#ifdef POINTS
static double theta[POINTS], phi[POINTS];
PART segment(void) { waypoints(0.08, 0.8, -0.2, -0.5, 0.1, -0.4, theta, phi); }
static void all(void)
{
    measured(WAYPOINTS, segment);
    said((int32_t)(1e6 * theta[POINTS / 2]));
    said((int32_t)(1e6 * phi[POINTS / 2]));
}
#endif

#ifdef WAYS
/* The pairs of ends come with the subject; those from CORNERS on have names of their own. */
static double theta[WAYS], phi[WAYS];
static const double *pair;
#define ENDS 0.08, 0.8, pair[0], pair[1], pair[2], pair[3]
static int tries;
PART projected(void) { chord(ENDS, WAYS, theta, phi); }
PART corrected(void) { waypoints(ENDS, theta, phi); }
PART shot(void) { tries = geodesic(ENDS, WAYS, theta, phi); }
PART relaxed(void) { tries = geodesic_relaxed(ENDS, WAYS, theta, phi); }
PART textbook(void) { tries = geodesic_textbook(ENDS, WAYS, theta, phi); }
static void all(void)
{
    static void (*const parts[5])(void) = {projected, corrected, shot, relaxed, textbook};
    for (int i = 0; i < (int)(sizeof pairs / sizeof *pairs); ++i) {
        pair = pairs[i];
        for (int k = 0; k < 5; ++k) {
            tries = 1;
            measured((uint8_t)(PAIRS + (i < CORNERS ? k : 5 + k)), parts[k]);
            said(tries);
            for (int j = 0; j < WAYS; ++j) {
                said((int32_t)(1e8 * theta[j]));
                said((int32_t)(1e8 * phi[j]));
            }
        }
    }
}
#endif

int main(void)
{
    measured(EMPTY, empty);
    all();
    stop();
    return 0;
}

#ifndef __AVR__
extern uint32_t top_of_stack;
static void reset(void)
{
    extern uint32_t data_from, data_begin, data_end, bss_end;
    uint32_t *to = &data_begin;
    for (uint32_t *from = &data_from; to < &data_end;) *to++ = *from++;
    while (to < &bss_end) *to++ = 0;
#ifdef __ARM_FP
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20;  /* the unit for floating point */
    __asm__ volatile("dsb\nisb");
#endif
    TIMER[1] = 0xFFFFFF;
    TIMER[2] = 0;
    TIMER[0] = TIMER_MODE;
    main();
}
static void fault(void) { call(0x18, (void *)0x20024); }
__attribute__((section(".vectors"), used)) static void *vectors[16] =
    { &top_of_stack, (void *)reset, (void *)fault, (void *)fault, [15] = (void *)again };
#endif
