/* Handlers held up by another one of the program: F13, F20. */
#include "rows.h"

#define BITS      10
#define BIT       (RIG_BYTE / BITS) // cycles
#define HOLD_ENDS 40                // cycles of the holding handler besides its loops
#define RELEASE   40                // cycles of the handler that lets go
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
                check->holds = true;
                check->rules = RULE(RULE_OVERRUN);
                check->slack_us = holds[n] / RIG_US;
                rig_hold(check->rig, begins + 2 * RIG_US + at + RELEASE, (uint16_t)(holds[n] / 4));
                check_run(check, job);
                unsigned lost = check->rig->overruns, told = check->moved.overruns;
                check_outcome(check, lost ? OUTCOME(CDS_CORRUPT) : GOOD);
                if (told > lost || (lost && !told)) {
                    check_fail(check, "overruns: %u, expected 1 to %u", told, lost);
                }
                check_after(check);
            }
        }
    }
}

/* --- F20: transmit complete --- */

/* The handler begins between others, so that none holds it up in its turn, and ends when the
 * release has been due for so many cycles. */
static void hold_release(struct check *check, const struct job *job, unsigned cycles)
{
    struct rig *rig = check->rig;
    int64_t complete = rows_packet_size(job) * RIG_BYTE;
    if (rig_tied(rig)) { // behind the one that gives the last byte, before that of the echo
        rig_hold(rig, complete - 215, (uint16_t)((cycles + 185) / 4));
    } else {
        uint16_t loops = (uint16_t)((cycles + 100) / 4);
        rig_hold(rig, complete + cycles - 4 * loops - HOLD_ENDS, loops);
    }
    check_run(check, job);
    uint64_t end = rig->sent.bytes[check->asked.size - 1].time + RIG_BYTE;
    uint64_t latest = (rig->hold_until > end ? rig->hold_until : end) + RELEASE;
    // once in 32 ms the clock's handler comes first, and the one held up is that of the last byte
    bool gap = end - rig->sent.bytes[0].time > (uint64_t)complete;
    if (!gap &&
        (rig->hold_until + BIT < end + cycles || rig->hold_until > end + cycles + 2 * BIT)) {
        check_fail(check, "held up for %d cycles", (int)(rig->hold_until - end));
    }
    if (!rig_tied(rig) && (rig->released < end || rig->released > latest)) {
        check_fail(check, "released %d cycles behind the last stop bit",
                   (int)(rig->released - end));
    }
}

/* Amid the packet: the transmitter runs dry and says that it is done, long before it is. */
static void hold_amid(struct check *check)
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
                check->holds = !patient;
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

/* 40 us: the servo waits until the line is let go of, at the latest. */
static void hold_patient(struct check *check)
{
    check->servos[0].registers[TABLE_RETURN_DELAY] = 20;
    rig_node(check->rig, 0)->servo.registers[TABLE_RETURN_DELAY] = 20;
    hold(check, true);
}

/* 2 us, the factory's: its reply meets the driver, or overruns a receiver whose handler waits too.
 */
static void hold_prompt(struct check *check)
{
    hold(check, false);
}

const struct row rows_handler[] = {
    {"F13", "receive handler held up for 320 to 700 cycles, every bit of a reply", "1,2", overrun,
     0},
    {"F20-patient", "release held up for 0 to 400 cycles, return delay 40 us", "1,2", hold_patient,
     0},
    {"F20-amid", "next byte held up for 180 to 480 cycles, every bit of a packet", "1,2", hold_amid,
     0},
    {"F20-prompt", "release held up for 0 to 400 cycles, return delay 2 us", "1,2", hold_prompt, 0},
    {0},
};
