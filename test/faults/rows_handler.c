/* SPDX-License-Identifier: MIT */
/* A handler of the program delays the handlers of the bus: F13, F20. */
#include "rows.h"

#define BITS      10
#define BIT       (RIG_BYTE / BITS) // cycles
#define HOLD_ENDS 40                // cycles of the holding handler besides its loops
#define RELEASE   40                // cycles of the transmit-complete handler
#define HELD_MOST 400

/* --- F13: overrun --- */

static void overrun(struct check *check)
{
    static const unsigned holds[] = {320, 480, 700};
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        const struct job *job = &rows_jobs[i];
        unsigned begins = rows_packet_size(job) * RIG_BYTE;
        for (unsigned at = 0; at < rows_reply_size(job) * RIG_BYTE; at += BIT) {
            for (unsigned n = 0; n < sizeof(holds) / sizeof(holds[0]); n++) {
                if (!check_next(check, "%s, %u cycles from cycle %u of the reply", check_name(job),
                                holds[n], at)) {
                    continue;
                }
                check->allows_overruns = true;
                check->rules = RULE(RULE_OVERRUN);
                check->slack_us = holds[n] / RIG_US;
                rig_hold(check->rig, begins + 2 * RIG_US + at + RELEASE, (uint16_t)(holds[n] / 4));
                check_run(check, job);
                unsigned lost = check->rig->overruns, counted = check->last_stats.overruns;
                check_outcome(check, lost ? OUTCOME(CDS_CORRUPT) : GOOD);
                if (counted > lost || (lost && !counted)) {
                    check_fail(check, "overruns: %u, expected 1 to %u", counted, lost);
                }
                check_after(check);
            }
        }
    }
}

/* --- F20: transmit complete --- */

/* Delays the release of the driver: the holding handler ends `cycles` after the release was due. It
 * begins between two other handlers, so that neither delays it. */
static void hold_release(struct check *check, const struct job *job, unsigned cycles)
{
    struct rig *rig = check->rig;
    int64_t complete = rows_packet_size(job) * RIG_BYTE;
    if (rig_tied(rig)) { // after the handler that sends the last byte, before that of its echo
        rig_hold(rig, complete - 215, (uint16_t)((cycles + 185) / 4));
    } else {
        uint16_t loops = (uint16_t)((cycles + 100) / 4);
        rig_hold(rig, complete + cycles - 4 * loops - HOLD_ENDS, loops);
    }
    check_run(check, job);
    uint64_t end = rig->sent.bytes[check->asked.size - 1].time + RIG_BYTE;
    uint64_t latest = (rig->hold_until > end ? rig->hold_until : end) + RELEASE;
    // every 32 ms the clock's handler runs first; then the handler of the last byte is delayed
    bool gap = end - rig->sent.bytes[0].time > (uint64_t)complete;
    if (!gap &&
        (rig->hold_until + BIT < end + cycles || rig->hold_until > end + cycles + 2 * BIT)) {
        check_fail(check, "release delayed by %d cycles", (int)(rig->hold_until - end));
    }
    if (!rig_tied(rig) && (rig->released < end || rig->released > latest)) {
        check_fail(check, "released %d cycles after the last stop bit", (int)(rig->released - end));
    }
}

/* The next byte of the packet comes late. The transmitter runs empty and reports transmit complete
 * before the packet is complete. */
static void hold_next_byte(struct check *check)
{
    static const unsigned holds[] = {180, 320, 480};
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        const struct job *job = &rows_jobs[i];
        for (unsigned n = 0; n < sizeof(holds) / sizeof(holds[0]); n++) {
            unsigned last = rows_packet_size(job) * RIG_BYTE - holds[n] - RIG_BYTE;
            for (unsigned at = 0; at < last; at += BIT) {
                if (!check_next(check, "%s, %u cycles from cycle %u of the packet", check_name(job),
                                holds[n], at)) {
                    continue;
                }
                check->slack_us = holds[n] / RIG_US;
                rig_hold(check->rig, at, (uint16_t)(holds[n] / 4));
                check_run(check, job);
                check_outcome(check, GOOD);
                check_after(check);
            }
        }
    }
}

static void hold(struct check *check, bool patient)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned cycles = 0; cycles <= HELD_MOST; cycles++) {
            if (check_next(check, "%s, %u cycles", check_name(&rows_jobs[i]), cycles)) {
                check->slack_us = HELD_MOST / RIG_US;
                check->allows_overruns = !patient;
                check->rules = patient ? 0
                               : rig_tied(check->rig)
                                   ? RULE(RULE_OVERRUN)
                                   : RULE(RULE_TWO_DRIVERS) | RULE(RULE_REPLY_LOST);
                hold_release(check, &rows_jobs[i], cycles);
                bool lost = check->rig->overruns;
                check_outcome(check, patient                 ? GOOD
                                     : !rig_tied(check->rig) ? GOOD | FAILED
                                     : lost                  ? OUTCOME(CDS_CORRUPT)
                                                             : GOOD);
                check_after(check);
            }
        }
    }
}

/* Return delay 40 us: the driver is always released before the reply. */
static void hold_patient(struct check *check)
{
    check->servos[0].registers[TABLE_RETURN_DELAY] = 20;
    rig_node(check->rig, 0)->servo.registers[TABLE_RETURN_DELAY] = 20;
    hold(check, true);
}

/* Return delay 2 us (factory value): the reply can meet the driver. On tied pins it can overrun the
 * receiver, whose handler is delayed too. */
static void hold_prompt(struct check *check)
{
    hold(check, false);
}

const struct row rows_handler[] = {
    {"F13", "receive handler delayed by 320 to 700 cycles, at every bit of a reply", "1,2", overrun,
     0},
    {"F20-patient", "release delayed by 0 to 400 cycles, return delay 40 us", "1,2", hold_patient,
     0},
    {"F20-amid", "next byte delayed by 180 to 480 cycles, at every bit of a packet", "1,2",
     hold_next_byte, 0},
    {"F20-prompt", "release delayed by 0 to 400 cycles, return delay 2 us", "1,2", hold_prompt, 0},
    {0},
};
