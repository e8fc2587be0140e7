/* Why does it not answer? One call that looks at the line, at one servo and at those around it, and
 * ends with one finding and what to do about it. It sends PING and READ only, and writes nothing
 * (manual 2.4.2, 2.4.5; registers: 3.1).
 *
 * The most fundamental cause comes first; what is further down is not looked for:
 *   1. the line, unasked, for 50 ms: LINE_LOW; packets of others: COLLISION; bytes: BABBLE if it is
 *      never quiet, else NOISE
 *   2. in every series of questions: ECHO, COLLISION, BYTES_LOST, and DUPLICATE_ID if good answers
 *      come twice
 *   3. PING of the servo is silent: SLOW if answers come too late; then the other listed rates,
 *      and whoever else is there: OTHER_RATE, OTHER_ID, else SILENCE
 *   4. READ is silent where PING is not: NO_REPLY_BY_LEVEL
 *   5. damage: of a quarter of all answers or more only the first bytes are lost, and there is not
 *      a third as much of another sort: REPLIES_TOO_EARLY. Only where two servos would say
 * different things (READ of position, voltage ...), and not in PING and READ of the ID:
 * DUPLICATE_ID. In half of all answers or more: DUPLICATE_ID if another servo is understood, or if
 * none is there and three quarters are damaged; else NOISE. One bad exchange of sixteen is nothing,
 * nor are more if a second examination is clean, once it hears again: real buses lose a few in a
 * thousand. Up to three bytes unasked are nothing either
 *   6. what the servo says of itself: SLOW, LOW_SUPPLY, HIGH_SUPPLY, OVERHEATED, OVERLOADED
 *
 * At 1 Mbps a servo that is well takes 0.1 s and 20 exchanges, silence 0.2 s and 31. Where others
 * must be looked for there are at most 300 exchanges in 0.4 s, 2.2 s at 19200; of anybody twice as
 * many. Two servos that agree to the bit, in values and in time, pass for one.
 *
 * Broadcast PING is sent only where nobody answers, or to look for anybody: several servos answer
 * it at once then, for 60 us. Keep other requests off the bus meanwhile, as in a scan. What an
 * observer knows of servos is not used. Main context.
 */
#ifndef CDS_DIAGNOSE_H
#define CDS_DIAGNOSE_H

#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus, struct cds_request

#ifdef __cplusplus
extern "C" {
#endif

/* X(name, number, text, remedy) */
#define CDS_FINDINGS(X)                                                                            \
    X(CDS_FINDING_NONE, 0, "nothing found yet", "go on polling")                                   \
    X(CDS_FINDING_OK, 1, "the servo answers and is well", "nothing to do")                         \
    X(CDS_FINDING_LINE_LOW, 2, "the line is held low",                                             \
      "look for a short circuit, a plug turned round, or a driver without power")                  \
    X(CDS_FINDING_BABBLE, 3, "the line is never quiet",                                            \
      "unplug one servo after the other until it is; then look at that one")                       \
    X(CDS_FINDING_ECHO, 4, "own bytes come back, though the board says they do not",               \
      "check RX enable; or describe the board as one with an echo")                                \
    X(CDS_FINDING_COLLISION, 5, "somebody else sends on this line",                                \
      "let one controller only talk: unplug the other, or an adapter to a PC")                     \
    X(CDS_FINDING_NOISE, 6, "the line is disturbed",                                               \
      "check plugs, ground and cable length; keep it away from motor and mains cables")            \
    X(CDS_FINDING_BYTES_LOST, 7, "this controller was too late for bytes",                         \
      "shorten interrupt handlers, or begin them with ISR_NOBLOCK")                                \
    X(CDS_FINDING_DUPLICATE_ID, 8, "two servos seem to have this ID",                              \
      "connect one of them alone and give it another ID")                                          \
    X(CDS_FINDING_SILENCE, 9, "nobody answers, at any listed rate",                                \
      "check power, plug and wiring; then a rescue scan for rates that are not listed")            \
    X(CDS_FINDING_OTHER_RATE, 10, "it answers at another baud rate",                               \
      "use that rate, or change the servo's baud rate")                                            \
    X(CDS_FINDING_OTHER_ID, 11, "nobody has this ID, but others answer",                           \
      "check the ID: scan the bus")                                                                \
    X(CDS_FINDING_NO_REPLY_BY_LEVEL, 12, "it answers PING only",                                   \
      "set its STATUS_RETURN_LEVEL to 1 (READ) or 2 (all)")                                        \
    X(CDS_FINDING_SLOW, 13, "it answers later than the bus waits",                                 \
      "lower its RETURN_DELAY, or tell the bus with cds_bus_set_return_delay()")                   \
    X(CDS_FINDING_LOW_SUPPLY, 14, "its supply is below MIN_VOLTAGE",                               \
      "charge or change the battery; check cables and plugs under load")                           \
    X(CDS_FINDING_HIGH_SUPPLY, 15, "its supply is above MAX_VOLTAGE",                              \
      "lower the supply before it does harm")                                                      \
    X(CDS_FINDING_OVERHEATED, 16, "it is hotter than MAX_TEMPERATURE",                             \
      "take off torque and load until it is cool")                                                 \
    X(CDS_FINDING_OVERLOADED, 17, "its load exceeds its torque",                                   \
      "look what blocks it, and lessen the load")                                                  \
    X(CDS_FINDING_REPLIES_TOO_EARLY, 18, "it answers before this controller listens",              \
      "write RETURN_DELAY 1 or more: it hears that; 0 is for tied pins")

/* CDS_FINDING_OK, ...: what each one means stands in the list. */
enum cds_finding {
#define CDS_FINDING_ENUM_(name, number, text, remedy) name = number,
    CDS_FINDINGS(CDS_FINDING_ENUM_)
#undef CDS_FINDING_ENUM_
};

/* found_id where nobody is known by an ID. */
#define CDS_DIAGNOSE_NOBODY 0xFF

/* The least buffer of its request, in bytes. */
#define CDS_DIAGNOSE_SIZE 9

/* How exchanges ended. */
struct cds_diagnose_tally {
    uint8_t asked;    // exchanges, of which were
    uint8_t answered; // ... clean,
    uint8_t damaged;  // ... damaged, the servo's complaint of damage included,
    uint8_t silent;   // ... without a sign of anybody,
    uint8_t busy;     // ... not possible: the line was not quiet
    uint8_t echoed;   // of all: began with own bytes
    uint8_t cut;      // of the damaged: whole but for the first bytes
};

/* One diagnosis: the caller reads `finding` and all below it that is not its own. */
struct cds_diagnose {
    struct cds_bus *bus;
    struct cds_request *request;
    uint8_t id;         // who was asked for
    uint8_t finding;    // enum cds_finding; stands when polling ends with CDS_OK
    uint8_t found_id;   // who was examined or found, or CDS_DIAGNOSE_NOBODY
    uint8_t found_baud; // register value of the rate at which it answered
    uint8_t error;      // CDS_ERROR_* bits of its last answer to READ
    uint16_t value;     // SLOW: us it waits, 0 if that is not known; LOW_, HIGH_SUPPLY: mV;
                        // OVERHEATED: degrees Celsius

    /* Evidence; */
    struct cds_diagnose_tally total;  // of all exchanges with the servo examined
    uint16_t unasked;                 // bytes, damaged ones too, heard while nobody was asked;
    uint16_t extra, late;             // of the bus's counters, how much they moved: answers of
                                      // `found_id`
    uint16_t foreign;                 // packets of others, unasked
    uint16_t echo_errors;             // own bytes that came back changed
    uint16_t overruns;                // bytes that this controller lost
    uint16_t exchanges;               // progress: PINGs and READs that are over
    struct cds_diagnose_tally series; // its own, down to `limits`
    uint8_t phase, purpose, aborted, in_flight, crowd, limits_known, looked_again;
    uint8_t target, candidate, seek_id, rates_left, sent_size, head, result;
    uint16_t return_delay_us;
    uint8_t repeats, baud, own_baud;
    uint32_t since_us, pause_us;
    uint8_t sent[8], feedback[8], limits[9];
    struct cds_diagnose_tally ping, same, differing; // evidence: of `total`, PING, READ of the same
                                                     // and of what differs
    struct cds_counters base;                        // its own
};

/* Prepares a diagnosis of servo `id` (0 to 253), or, CDS_BROADCAST_ID, of whoever is found first,
 * at the bus's rate and return delay; nothing is sent before the first poll. The request's buffer
 * must be at least CDS_DIAGNOSE_SIZE bytes; bus, request and diagnose stay in place until it has
 * ended. CDS_OK; CDS_BAD_ARGUMENT: no bus is open, or `id` is 0xFF; CDS_NO_ROOM: the buffer is too
 * small; CDS_BUSY: the request is on its way for someone else. */
enum cds_result cds_diagnose_begin(struct cds_diagnose *diagnose, struct cds_bus *bus,
                                   struct cds_request *request, uint8_t id);

/* Ends it with the exchange in flight: go on polling until it is over. */
void cds_diagnose_abort(struct cds_diagnose *diagnose);

/* Moves on by at most one exchange; call it and cds_bus_poll() from the main loop, at least every
 * millisecond, or it hears less of what is said unasked. When it ends, the bus has its own rate,
 * return delay and repeats back. CDS_PENDING: not over yet. CDS_OK: diagnose->finding says what was
 * found. CDS_CANCELLED: aborted, or its request was cancelled; or the bus was opened anew, or told
 * another return delay, and nothing was given back.
 */
enum cds_result cds_diagnose_poll(struct cds_diagnose *diagnose);

#ifdef __cplusplus
}
#endif

#endif
