/* A line that is never quiet, or stuck: F9, F10. */
#include "rows.h"

/* --- F9: babble ----------------------------------------------------------------------------------
 */

static void babble(struct check *check, const struct job *job, const char *what, unsigned phase)
{
    if (!check_next(check, "%s, babble %s, phase %u", check_name(job), what, phase)) {
        return;
    }
    check->slack_us = 400; // handlers and parser are busy
    rig_pass(check->rig, phase);
    rig_order(check->rig, "babble %s", what);
    rig_pass(check->rig, 500 * RIG_US);
    check_run(check, job);
    check_outcome(check, GOOD | FAILED); // GOOD: headers at the very phase of the reply
    rig_order(check->rig, "babble off");
    check_after(check);
}

static void babble_bytes(struct check *check)
{
    for (unsigned value = 0; value < 256; value++) {
        for (unsigned i = 0; i < ROWS_JOBS; i++) {
            char what[8];
            snprintf(what, sizeof(what), "%u", value);
            babble(check, &rows_jobs[i], what, value % RIG_BYTE);
        }
    }
}

static void babble_headers(struct check *check)
{
    for (unsigned phase = 0; phase < RIG_BYTE; phase++) {
        babble(check, &rows_jobs[phase % ROWS_JOBS], "headers", phase);
        babble(check, &rows_jobs[(phase + 1) % ROWS_JOBS], "headers", phase);
    }
}

static void babble_random(struct check *check)
{
    for (unsigned phase = 0; phase < 1000; phase++) {
        babble(check, &rows_jobs[phase % ROWS_JOBS], "random", phase % RIG_BYTE);
    }
}

/* --- F10: stuck ----------------------------------------------------------------------------------
 */

static void stick(struct check *check, const char *level)
{
    static const unsigned for_us[] = {1, 10, 37, 200, 1500};
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned us = 0; us < 300; us += 3) {
            for (unsigned n = 0; n < sizeof(for_us) / sizeof(for_us[0]); n++) {
                if (check_next(check, "%s, after %u us for %u us", check_name(&rows_jobs[i]), us,
                               for_us[n])) {
                    check->misunderstood = true; // a microsecond is a bit of a LENGTH, too
                    rig_order_in(check->rig, us * RIG_US, "stuck %s", level);
                    rig_order_in(check->rig, (us + for_us[n]) * RIG_US, "stuck off");
                    check_run(check, &rows_jobs[i]);
                    check_outcome(check, GOOD | FAILED);
                    rig_pass(check->rig, (us + for_us[n]) * RIG_US);
                    check_after(check);
                }
            }
        }
    }
}

static void stick_low(struct check *check)
{
    stick(check, "low");
}

static void stick_high(struct check *check)
{
    stick(check, "high");
}

/* Again and again, for up to half a second. */
static void stay_stuck(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned low = 0; low < 2; low++) {
            if (!check_next(check, "%s, %s", check_name(&rows_jobs[i]), low ? "low" : "high")) {
                continue;
            }
            rig_order(check->rig, "stuck %s", low ? "low" : "high");
            for (unsigned n = 0; n < 500; n++) {
                check_run(check, &rows_jobs[i]);
                check_outcome(check, FAILED);
                rig_forget(check->rig);
            }
            rig_order(check->rig, "stuck off");
            check_after(check);
        }
    }
}

const struct row rows_line[] = {
    {"F9-bytes", "a servo says one byte for ever, every value", "1,2", babble_bytes, 0},
    {"F9-headers", "FF for ever, every phase", "1,2", babble_headers, 0},
    {"F9-random", "random bytes for ever", "1,2", babble_random, 0},
    {"F10-low", "line stuck low for 1 us to 1.5 ms, every 3 us of an exchange", "1,2", stick_low,
     0},
    {"F10-high", "line stuck high, likewise", "1,2", stick_high, 0},
    {"F10-stays", "line stuck for 500 exchanges", "1,2", stay_stuck, 0},
    {0},
};
