/* SPDX-License-Identifier: MIT */
/* A line that is never quiet (F9) or stuck (F10). */
#include "rows.h"

/* --- F9: babble --- */

/* Checks that the request ends as CDS_LINE_BUSY, nothing is sent and the bus reports `state`. */
static void check_line_busy(struct check *check, const struct job *job, enum cds_bus_line state)
{
    check_run(check, job);
    check_outcome(check, OUTCOME(CDS_LINE_BUSY));
    if (check->rig->sent.count) {
        check_fail(check, "%u bytes were sent", check->rig->sent.count);
    }
    if (check->outcome.state != state) {
        check_fail(check, "line state %u", check->outcome.state);
    }
}

static void babble(struct check *check, const struct job *job, const char *what, unsigned phase)
{
    if (!check_next(check, "%s, babble %s, phase %u", check_name(job), what, phase)) {
        return;
    }
    check_allow_babble(check);
    rig_pass(check->rig, phase);
    rig_order(check->rig, "babble %s", what);
    rig_pass(check->rig, 500 * RIG_US);
    check_line_busy(check, job, CDS_BUS_LINE_SUSPECT);
    rig_order(check->rig, "babble off");
    check_after(check);
}

/* The babble begins during a transaction. This transaction may have any outcome; the next one must
 * not be sent. If the babble begins while the program still builds the packet, the first one need
 * not be sent either. */
static void babble_begins(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS * 2; i++) {
        const struct job *job = &rows_jobs[i / 2];
        for (unsigned us = 0; us < 900; us += 3) {
            const char *what = i % 2 ? "headers" : "random";
            if (!check_next(check, "%s, %s from %u us on", check_name(job), what, us)) {
                continue;
            }
            check_allow_babble(check);
            check->allows_wrong_command = check->allows_wrong_value = true; // the bytes are random
            uint64_t from = rig_now(check->rig) + us * RIG_US, until = from + 200 * RIG_US;
            rig_order_in(check->rig, us * RIG_US, "babble %s", what);
            check_run(check, job);
            bool before = from < check->rig->begun + CHECK_PROCESSING_US * RIG_US;
            check_outcome(check, GOOD | FAILED | (before ? OUTCOME(CDS_LINE_BUSY) : 0));
            rig_pass(check->rig, until > rig_now(check->rig) ? until - rig_now(check->rig) : 1);
            check_forget(check);
            check_line_busy(check, &rows_jobs[1], CDS_BUS_LINE_SUSPECT);
            rig_order(check->rig, "babble off");
            check->job = *job;
            check_after(check);
        }
    }
}

/* The babble has ended while a request waited: checks that the line was quiet for two byte times
 * before the packet. The library reads the clock up to 5 us before the ring, and 8 us or more
 * before the first start bit. */
static void check_silence(struct check *check)
{
    const struct tap *received = &check->rig->received;
    uint64_t sent = check->rig->sent.bytes[0].time, last = 0;
    for (unsigned i = 0; i < received->count && received->bytes[i].time < sent; i++) {
        last = received->bytes[i].time;
    }
    if (sent < last + (CHECK_QUIET_US - 5 + 8) * RIG_US) {
        check_fail(check, "sent %.1f us after the last byte", (double)(sent - last) / RIG_US);
    }
}

static void babble_ends(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS * 2; i++) {
        const struct job *job = &rows_jobs[i / 2];
        for (unsigned us = 100; us < 1300; us += 7) {
            const char *what = i % 2 ? "headers" : "85"; // neither contains a packet
            if (!check_next(check, "%s, %s for %u us", check_name(job), what, us)) {
                continue;
            }
            check_allow_babble(check);
            rig_order(check->rig, "babble %s", what);
            rig_pass(check->rig, 50 * RIG_US);
            rig_order_in(check->rig, us * RIG_US, "babble off");
            check_run(check, job);
            bool may_give_up = us > 1000; // about as long as the bus waits
            check_outcome(check, GOOD | (may_give_up ? OUTCOME(CDS_LINE_BUSY) : 0));
            if (check->rig->sent.count) {
                check_silence(check);
            }
            check_after(check);
        }
    }
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

/* --- F10: stuck --- */

static void stick(struct check *check, bool low)
{
    static const unsigned for_us[] = {1, 10, 37, 200, 1500};
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned us = 0; us < 300; us += 3) {
            for (unsigned n = 0; n < sizeof(for_us) / sizeof(for_us[0]); n++) {
                if (check_next(check, "%s, after %u us for %u us", check_name(&rows_jobs[i]), us,
                               for_us[n])) {
                    check->allows_wrong_command = true; // one microsecond can be a bit of LENGTH
                    uint64_t until = (us + for_us[n]) * RIG_US;
                    check->low_until = low ? rig_now(check->rig) + until : 0;
                    rig_order_in(check->rig, us * RIG_US, low ? "stuck low" : "stuck high");
                    rig_order_in(check->rig, until, "stuck off");
                    check_run(check, &rows_jobs[i]);
                    // if the line is low before the packet, for longer than the bus waits
                    bool may_wait = low && for_us[n] > CHECK_QUIET_WAIT_US;
                    check_outcome(check, GOOD | FAILED | (may_wait ? OUTCOME(CDS_LINE_BUSY) : 0));
                    if (check->outcome.result == CDS_LINE_BUSY &&
                        check->outcome.state != CDS_BUS_LINE_FAULT) {
                        check_fail(check, "line state %u", check->outcome.state);
                    }
                    rig_pass(check->rig, until);
                    check_after(check);
                }
            }
        }
    }
}

static void stick_low(struct check *check)
{
    stick(check, true);
}

static void stick_high(struct check *check)
{
    stick(check, false);
}

/* The line is stuck for 500 transactions, up to half a second. Stuck high is the same as a line
 * without servos. Stuck low is a line fault, and nothing is sent. */
static void stay_stuck(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned low = 0; low < 2; low++) {
            if (!check_next(check, "%s, %s", check_name(&rows_jobs[i]), low ? "low" : "high")) {
                continue;
            }
            rig_order(check->rig, "stuck %s", low ? "low" : "high");
            check->low_until = low ? UINT64_MAX / 2 : 0;
            rig_pass(check->rig, 100 * RIG_US);
            for (unsigned n = 0; n < 500; n++) {
                if (low) {
                    check_line_busy(check, &rows_jobs[i], CDS_BUS_LINE_FAULT);
                } else {
                    check_run(check, &rows_jobs[i]);
                    check_outcome(check, OUTCOME(CDS_TIMEOUT));
                }
                check_forget(check);
            }
            rig_order(check->rig, "stuck off");
            check->low_until = rig_now(check->rig);
            check_after(check);
            if (check->injection_stats.framing_errors != low) { // the one 00 at the beginning
                check_fail(check, "%u framing errors", check->injection_stats.framing_errors);
            }
        }
    }
}

const struct row rows_line[] = {
    {"F9-bytes", "a servo sends one byte for ever, every value: nothing is sent", "1,2",
     babble_bytes, 0},
    {"F9-headers", "FF for ever, every phase: nothing is sent", "1,2", babble_headers, 0},
    {"F9-random", "random bytes for ever: nothing is sent", "1,2", babble_random, 0},
    {"F9-begins", "FF or random bytes for ever, from every 3 us of a transaction on", "1,2",
     babble_begins, 0},
    {"F9-ends", "FF or 55 for 0.1 to 1.3 ms while a request waits", "1,2", babble_ends, 0},
    {"F10-low", "line stuck low for 1 us to 1.5 ms, every 3 us of a transaction", "1,2", stick_low,
     0},
    {"F10-high", "line stuck high for 1 us to 1.5 ms, every 3 us of a transaction", "1,2",
     stick_high, 0},
    {"F10-stays", "line stuck for 500 transactions", "1,2", stay_stuck, 0},
    {0},
};
