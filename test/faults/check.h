/* One injection of `make faults` and what is checked of it, whatever the fault:
 *
 * - the call ends by its deadline, and no sooner if it failed; the driver has let go, and no rule
 * of the wire was broken;
 * - the controller said the packet asked for and nothing else;
 * - outcome, values and counters are those that oracle.h makes of the bytes heard;
 * - no byte was stored behind the reply;
 * - a value is one that a servo gave; if not it is counted, and must have been foreseen;
 * - no servo holds anything that was not asked for, unless it heard a packet that says so;
 * - the next exchange, without a fault, is good.
 *
 * What the outcome of a fault may be is the row's to say (rows.h).
 */
#ifndef CHECK_H
#define CHECK_H

#include <stdbool.h>
#include <stdint.h>

#include "oracle.h"
#include "rig.h"

/* The program's own time, at 16 MHz, which the deadline leaves out: it builds the packet before the
 * clock is started, and looks at what has come before it looks at the clock. Each byte of data is
 * parsed, and copied. */
#define CHECK_PROCESSING_US 130u
#define CHECK_BYTE_US       3u
#define CHECK_BYTE_TIED_US  8u // while more are coming: the handlers take most of the time there is

/* What a bus allows for. */
#define CHECK_RETURN_DELAY_US 508u // unless it is told better
#define CHECK_MARGIN_US       100u
#define CHECK_QUIET_US        20u // two byte times
/* A reply that begins so late behind its packet is still not taken for another one: no packet that
 * is answered goes out before it is over. */
#define CHECK_STALE_REPLY_US 2000u
/* ... and until a request is given up that cannot be sent: the longest reply there may be. */
#define CHECK_QUIET_WAIT_US (56u * 10u + CHECK_RETURN_DELAY_US + CHECK_MARGIN_US)

#define OUTCOME(result) (1u << (result))
#define GOOD            OUTCOME(CDS_OK)
#define FAILED          (OUTCOME(CDS_TIMEOUT) | OUTCOME(CDS_CORRUPT))
#define RULE(rule)      (1u << (rule))

struct row;

/* What was heard from one packet of the controller's to the next, as in oracle.h. How many bytes
 * were in time may be uncertain, near to the deadline. */
struct check_span {
    struct oracle_asked asked;
    bool asks;
    struct oracle_byte bytes[RIG_ROOM];
    uint64_t times[RIG_ROOM];
    unsigned count;
    uint64_t echo_from, echo_until; // while the controller drives
    unsigned echoes;
    unsigned in_time_least, in_time_most;
    bool good;  // the attempt ended well,
    int result; // and if not: how; -1: one or the other
    uint8_t last_id;
    bool last_ok;
};

/* What is to be counted, at least or at most. */
struct check_sums {
    unsigned refuted, stray, late, extra, foreign;
};

struct check {
    struct rig *rig;
    const struct row *row;
    /* which injections are done: part 1 to `parts`, as `seed` divides them */
    uint32_t part, parts, seed;
    bool counting; // none: their number is wanted
    unsigned index, total;
    void (*on_progress)(const struct check *check);
    /* what came of them */
    unsigned injections, failures;
    unsigned undetected; // values taken that no servo gave
    unsigned commanded;  // servos that hold what was not asked for
    unsigned lost;       // good exchanges without reply, as a servo waited for the rest of a packet
    uint64_t longest;    // past the deadline, in cycles
    /* the present one; all but `text` are as they were at its beginning, unless the row says more
     */
    char text[120];
    bool failed;
    bool foreseen;      // that a wrong value is taken
    bool mixed;         // bits all over a reply are wrong: that may put its sum right again
    bool misunderstood; // ... and that a servo hears another command than the one asked for
    bool powered_up;    // servo 0 has lost its power behind the exchange
    bool holds;         // handlers are held up: bytes may overrun,
    bool blind;         // and did, or were not written down: the oracle knows nothing of them
    bool babbles;       // the receiver's ring may overflow
    uint64_t low_until; // cycle: the row itself keeps the line in use for so long
    int level;          // status return level that the bus knows of the servo
    uint8_t told;       // return delay, as in struct job
    uint8_t pause;      // the next exchange follows at once, but for such a one
    int baud;           // register of servo 0, where a fault has set it; -1: it has not
    uint32_t rules;     // RULE() that may be broken
    uint32_t slack_us;  // that the program may take besides
    uint8_t good_id;    // whom the next good exchange is with
    struct oracle_asked asked;
    struct job job;
    struct job_outcome outcome; // of the latest exchange, like the two above
    struct job_outcome look;    // the latest, of any job
    struct cds_stats before;    // the injection
    struct cds_stats moved;     // by the latest exchange
    struct cds_stats all;       // by the injection, as of check_settle()
    unsigned attempts;
    struct check_span span;         // since the latest packet
    struct check_sums least, most;  // by the spans before it
    uint8_t last_id;                // who had to answer last,
    bool last_ok;                   // and did
    uint64_t corrupt_at;            // when an exchange last ended so
    uint64_t rest_least, rest_most; // the rest behind the last failure ends between these
    unsigned judged;                // bytes heard that are accounted for,
    unsigned bad;                   // and those with a framing error among all
    bool several; // of them between two packets: what stands between may go unexamined
    unsigned echo_errors;
    struct servo *servos; // as they were put there
};

/* Prepares a rig that has just been opened. */
void check_open(struct check *check);
void check_close(struct check *check);

/* Is the injection described here to be done? Then the row arms the fault, and goes on. */
bool check_next(struct check *check, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Performs the job, and checks nothing but that it ends. */
void check_job(struct check *check, const struct job *job);

/* Performs the job, and checks all that is checked of every exchange. */
void check_run(struct check *check, const struct job *job);
/* The same of a job that is not admitted: nothing is sent. */
void check_refused(struct check *check, const struct job *job, enum cds_result result);
/* Forgets what was said and heard by now, once it is accounted for. */
void check_forget(struct check *check);
/* The line becomes quiet and the bus knows it; `all` and `look` are up to date, all is counted. */
void check_settle(struct check *check);
/* Bytes may still be coming at the deadline, as many as the reply has. */
void check_late_bytes(struct check *check, const struct job *job);
/* Somebody else talks on and on. */
void check_babble(struct check *check);
/* One of these outcomes, OUTCOME(...). */
void check_outcome(struct check *check, unsigned outcomes);
/* The fault is over: the line becomes quiet, the next exchange is good, servos are as they were. */
void check_after(struct check *check);
/* All three. */
void check_all(struct check *check, const struct job *job, unsigned outcomes);

/* Of any job: sent = ok + timeouts + corrupt. */
void check_sums(struct check *check);

void check_fail(struct check *check, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The packet that a job sends, and the reply without a fault. */
void check_asked(const struct job *job, struct oracle_asked *asked);
unsigned check_reply(const struct check *check, const struct job *job, uint8_t *packet);
const char *check_name(const struct job *job);

#endif
