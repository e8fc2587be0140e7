/* Series of questions, and what their answers tell; see diagnose.h. */
#include "cds55xx/diagnose.h"

#include <stdbool.h>
#include <string.h>

#include "cds55xx/scan.h"      // cds_scan_listed_bauds
#include "cds55xx/servo.h"     // cds_servo_ping(), cds_servo_read()
#include "flash.h"             // CDS_FLASH
#include "service/operation.h" // cds_operation_take()
#include "compiler.h"          // OPTIMIZER_BARRIER(), NOINLINE, DECLARED_NOINLINE()

#define LISTEN_US  50000u
#define SETTLE_US  2000u // ... before it, with 64 byte times: what was asked by others is answered
#define PAUSE_US   1000u // after a question, with 8 byte times: what comes late or twice comes now
#define NOISE      4     // bytes unasked; fewer are what good buses lose a few replies by
#define FEW        2     // of anything that may happen once on a good bus
#define SUPPLY_MV  100u  // unit of the registers
#define VARYING    8     // bytes from PRESENT_POSITION to PRESENT_TEMPERATURE
#define LIMITS_AT  CDS_REG_RETURN_DELAY
#define LIMITS_LEN (CDS_REG_MAX_VOLTAGE - LIMITS_AT + 1)

enum diagnose_phase {
    START,     // as soon as the bus is idle
    SETTLE,    // let late answers pass
    LISTEN,    // to the line, unasked
    KNOCK,     // PING of the target
    SAME,      // READ of what twins have in common: the ID
    DIFFERING, // READ of what they have not
    LIMITS,    // READ of return delay, temperature and voltage limits
    HASTE,     // PING with the bus's own return delay
    ANYONE,    // broadcast PING
    SEEK,      // PING of one ID after the other
    NAME,      // PING of the candidate
    WAKE,      // PING of the target until it hears again
    ELSEWHERE, // PING of the target at another rate
    ELSEWHERE_ANYONE,
    GIVE_BACK,
};

/* What the candidate is wanted for. */
enum diagnose_purpose { TO_EXAMINE, TO_TELL, TO_COMPARE };

/* Exchanges of a series. */
static const CDS_FLASH uint8_t wanted[] = {
    [KNOCK] = 4,     [SAME] = 6,
    [DIFFERING] = 6, [LIMITS] = 3,
    [HASTE] = 3,     [ANYONE] = 3,
    [SEEK] = 1,      [NAME] = 3,
    [WAKE] = 43, // of 6 bytes: more than any LENGTH
    [ELSEWHERE] = 2, [ELSEWHERE_ANYONE] = 2,
};

enum cds_result cds_diagnose_begin(struct cds_diagnose *diagnose, struct cds_bus *bus,
                                   struct cds_request *request, uint8_t id)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    if (bus->byte_time_us == 0 || id > CDS_BROADCAST_ID)
        return CDS_BAD_ARGUMENT;
    if (request->packet.capacity < CDS_DIAGNOSE_SIZE)
        return CDS_NO_ROOM;
    *diagnose = (struct cds_diagnose){
        .bus = bus,
        .request = request,
        .id = id,
        .target = id,
        .found_id = CDS_DIAGNOSE_NOBODY,
        .found_baud = bus->baud,
        .own_baud = bus->baud,
        .rates_left = CDS_SCAN_LISTED_BAUDS,
        .phase = START,
        .result = CDS_PENDING,
    };
    return CDS_OK;
}

void cds_diagnose_abort(struct cds_diagnose *diagnose)
{
    diagnose->aborted = 1;
}

static NOINLINE void rest(struct cds_diagnose *diagnose, uint16_t us, uint8_t bytes)
{
    diagnose->since_us = cds_port_now_us();
    diagnose->pause_us = us + (uint32_t)bytes * diagnose->bus->byte_time_us;
}

static void enter(struct cds_diagnose *diagnose, uint8_t phase)
{
    diagnose->phase = phase;
    diagnose->series = (struct cds_diagnose_tally){0};
    cds_bus_counters(diagnose->bus, &diagnose->base);
}

static void find(struct cds_diagnose *diagnose, enum cds_finding finding)
{
    diagnose->finding = (uint8_t)finding;
    if (finding == CDS_FINDING_DUPLICATE_ID && diagnose->found_id == CDS_DIAGNOSE_NOBODY)
        diagnose->found_id = diagnose->bus->last_id;
    enter(diagnose, GIVE_BACK);
}

static uint8_t target_of(const struct cds_diagnose *diagnose)
{
    switch (diagnose->phase) {
    case ANYONE:
    case ELSEWHERE_ANYONE: return CDS_BROADCAST_ID;
    case SEEK: return diagnose->seek_id;
    case NAME: return diagnose->candidate;
    default: return diagnose->target;
    }
}

/* ---- asking ---- */

/* The bus at the rate of this phase; false while it is busy. */
static bool tuned(struct cds_diagnose *diagnose)
{
    uint8_t baud = diagnose->own_baud;

    if (diagnose->phase == ELSEWHERE || diagnose->phase == ELSEWHERE_ANYONE)
        baud = diagnose->baud;
    return cds_operation_tune(diagnose->bus, baud);
}

static enum cds_result submit(struct cds_diagnose *diagnose)
{
    struct cds_request *request = diagnose->request;
    uint8_t id = target_of(diagnose);

    switch (diagnose->phase) {
    case SAME: return cds_servo_read(diagnose->bus, request, id, CDS_REG_ID, 1);
    case DIFFERING:
        return cds_servo_read(diagnose->bus, request, id, CDS_REG_PRESENT_POSITION, VARYING);
    case LIMITS: return cds_servo_read(diagnose->bus, request, id, LIMITS_AT, LIMITS_LEN);
    default: return cds_servo_ping(diagnose->bus, request, id);
    }
}

static void ask(struct cds_diagnose *diagnose)
{
    const struct cds_packet *packet = &diagnose->request->packet;
    enum cds_result submitted;

    if (diagnose->phase == HASTE) {
        if (cds_bus_rests(diagnose->bus, cds_port_now_us()))
            return; // this return delay holds only for a question that begins at once
        cds_bus_set_return_delay(diagnose->bus, diagnose->return_delay_us);
    }
    diagnose->head = diagnose->bus->link.rx.head;
    diagnose->request->vetted = true; // looking is always allowed, and must not wait less than told
    diagnose->request->skips_rest = diagnose->phase == SEEK; // each ID is asked once
    submitted = submit(diagnose);
    cds_operation_take(diagnose->bus); // the question keeps what it was submitted with
    diagnose->request->vetted = false; // without an observer nobody does
    if (submitted == CDS_OK) {
        diagnose->in_flight = 1;
        diagnose->sent_size = (uint8_t)packet->size; // the reply will overwrite it
        memcpy(diagnose->sent, packet->bytes, diagnose->sent_size);
    } else if (submitted != CDS_BUSY) {
        diagnose->result = (uint8_t)submitted;
    }
}

/* ---- one answer ---- */

/* Byte `index` of those heard since the question. */
static uint8_t heard_byte(const struct cds_diagnose *diagnose, uint8_t index)
{
    const struct cds_ring *rx = &diagnose->bus->link.rx;

    return rx->bytes[(uint8_t)(diagnose->head + index) & (CDS_RING_SIZE - 1)];
}

/* Are the first `count` bytes heard the last of the question, with a reply or nothing behind? */
static bool is_tail_of_own(const struct cds_diagnose *diagnose, uint8_t count, uint8_t heard)
{
    uint8_t from = (uint8_t)(diagnose->sent_size - count);

    for (uint8_t i = 0; i < count; i++) {
        if (heard_byte(diagnose, i) != diagnose->sent[from + i])
            return false;
    }
    return heard == count ||
           ((uint8_t)(heard - count) >= 2 && heard_byte(diagnose, count) == CDS_HEADER &&
            heard_byte(diagnose, (uint8_t)(count + 1)) == CDS_HEADER);
}

/* Does what was heard begin with an echo? All of a PING is none: of a servo with a voltage error it
 * is the answer. Nor is the end of one, if it is such an answer without its first bytes. */
static bool is_echo(const struct cds_diagnose *diagnose, uint8_t heard)
{
    uint8_t longest = diagnose->sent_size;

    if (diagnose->phase == KNOCK)
        longest--;
    for (uint8_t count = 1; count <= longest && count <= heard; count++) {
        if (is_tail_of_own(diagnose, count, heard))
            return true;
    }
    return false;
}

/* Is all that was heard the reply that was due, but for the first of its bytes? Checksum and
 * LENGTH say so: noise, or two servos at once, do not leave them right. With ERROR gone nothing
 * could be told. */
static bool is_cut(const struct cds_diagnose *diagnose, uint8_t heard)
{
    uint8_t id = target_of(diagnose);
    uint8_t length = (uint8_t)(diagnose->request->reply_parameters + CDS_LENGTH_MIN);
    uint8_t size = (uint8_t)(CDS_AT_ERROR + length); // which counts from there on
    uint8_t lost = (uint8_t)(size - heard);
    uint8_t sum = (uint8_t)(id + length);

    if (heard >= size || lost > CDS_AT_ERROR)
        return false;
    for (uint8_t i = lost; i < size; i++) {
        uint8_t byte = heard_byte(diagnose, (uint8_t)(i - lost));

        if (i >= CDS_AT_ERROR)
            sum = (uint8_t)(sum + byte);
        else if (byte != (i < CDS_AT_ID ? CDS_HEADER : i == CDS_AT_ID ? id : length))
            return false;
    }
    return sum == UINT8_MAX; // a checksum is the complement of the rest
}

static void count(struct cds_diagnose_tally *tally, uint8_t result, bool clean, bool heard,
                  bool echoed, bool cut)
{
    tally->asked++;
    if (echoed)
        tally->echoed++;
    if (cut && !echoed)
        tally->cut++;
    if (result == CDS_LINE_BUSY)
        tally->busy++;
    else if (clean)
        tally->answered++;
    else if (result != CDS_TIMEOUT || (heard && !echoed))
        tally->damaged++;
    else
        tally->silent++;
}

static void keep(struct cds_diagnose *diagnose)
{
    const struct cds_request *request = diagnose->request;

    if (diagnose->phase == ANYONE || diagnose->phase == ELSEWHERE_ANYONE)
        diagnose->candidate = request->id;
    if (diagnose->phase == DIFFERING) {
        diagnose->error = request->error;
        memcpy(diagnose->feedback, request->packet.bytes, VARYING);
    }
    if (diagnose->phase == LIMITS)
        memcpy(diagnose->limits, request->packet.bytes, LIMITS_LEN);
}

static void exchange_ended(struct cds_diagnose *diagnose)
{
    const struct cds_request *request = diagnose->request;
    uint8_t phase = diagnose->phase, result = request->result;
    uint8_t heard = (uint8_t)(diagnose->bus->link.rx.head - diagnose->head);
    bool clean = false, cut = is_cut(diagnose, heard), echoed = false;

    if (result == CDS_OK && !(request->error & CDS_ERRORS_OF_PACKET))
        clean = true;
    if (!cut || phase != KNOCK)
        echoed = is_echo(diagnose, heard);
    diagnose->exchanges++;
    count(&diagnose->series, result, clean, heard, echoed, cut);
    if (phase >= KNOCK && phase <= DIFFERING)
        count(&diagnose->total, result, clean, heard, echoed, cut);
    if (clean)
        keep(diagnose);
    if (phase != SEEK || heard || result != CDS_TIMEOUT)
        rest(diagnose, PAUSE_US, 8);
}

/* ---- what a series tells ---- */

static NOINLINE void add(uint16_t *sum, uint16_t now, uint16_t base)
{
    *sum = (uint16_t)(*sum + now - base);
}

/* Adds what the counters have moved since the series began. */
static void gather(struct cds_diagnose *diagnose)
{
    const struct cds_counters *base = &diagnose->base;
    struct cds_counters now;

    cds_bus_counters(diagnose->bus, &now);
    add(&diagnose->foreign, now.foreign, base->foreign);
    add(&diagnose->echo_errors, now.echo_errors, base->echo_errors);
    add(&diagnose->overruns, now.overruns, base->overruns);
    if (diagnose->bus->last_id != CDS_BROADCAST_ID) { // that one may be answered by several
        add(&diagnose->extra, now.extra, base->extra);
        add(&diagnose->late, now.late, base->late);
    }
    if (diagnose->phase == LISTEN) // bytes that were damaged are counted, not stored
        add(&diagnose->unasked, now.framing_errors, base->framing_errors);
    diagnose->base = now;
}

/* What makes every further question idle, or NONE. Whole echoes of PING pass for answers, so twice
 * is judged by READ. */
static NOINLINE enum cds_finding trouble(const struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;
    uint8_t phase = diagnose->phase;
    bool low = cds_bus_state(diagnose->bus) == CDS_BUS_FAULT;
    bool twice = diagnose->extra >= FEW;
    bool others = diagnose->foreign >= FEW;

    if (series->busy >= FEW)
        return low      ? CDS_FINDING_LINE_LOW
               : twice  ? CDS_FINDING_DUPLICATE_ID
               : others ? CDS_FINDING_COLLISION
                        : CDS_FINDING_BABBLE;
    if ((phase == KNOCK || phase == SAME || phase == ANYONE) && series->echoed == series->asked)
        return CDS_FINDING_ECHO;
    if (diagnose->echo_errors >= FEW || (others && (phase == SAME || phase == DIFFERING)))
        return CDS_FINDING_COLLISION;
    if (diagnose->unasked >= NOISE)
        return CDS_FINDING_NOISE;
    if (diagnose->overruns)
        return CDS_FINDING_BYTES_LOST;
    return twice && phase != KNOCK && phase != WAKE ? CDS_FINDING_DUPLICATE_ID : CDS_FINDING_NONE;
}

static void listened(struct cds_diagnose *diagnose)
{
    if (cds_bus_state(diagnose->bus) == CDS_BUS_FAULT)
        find(diagnose, CDS_FINDING_LINE_LOW);
    else if (diagnose->extra >= FEW)
        find(diagnose, CDS_FINDING_DUPLICATE_ID);
    else if (diagnose->foreign)
        find(diagnose, CDS_FINDING_COLLISION);
    else
        enter(diagnose, diagnose->target == CDS_BROADCAST_ID ? ANYONE : KNOCK);
}

/* Examines the target once more; false: that has been done. One damaged LENGTH makes a servo deaf
 * for up to 255 bytes, so one accident may spoil a whole examination; one that has answered before
 * is woken first, or the same accident would spoil the second, too. */
static bool look_again(struct cds_diagnose *diagnose)
{
    bool deaf = diagnose->series.silent && diagnose->found_id == diagnose->target;

    if (diagnose->looked_again)
        return false;
    diagnose->looked_again = 1;
    diagnose->total = (struct cds_diagnose_tally){0};
    enter(diagnose, deaf ? WAKE : KNOCK);
    return true;
}

static void nobody_is_there(struct cds_diagnose *diagnose)
{
    if (diagnose->target != CDS_BROADCAST_ID && look_again(diagnose))
        return;
    if (diagnose->found_id != CDS_DIAGNOSE_NOBODY)
        find(diagnose, CDS_FINDING_OTHER_ID);
    else
        find(diagnose, diagnose->crowd ? CDS_FINDING_NOISE : CDS_FINDING_SILENCE);
}

/* The next listed rate that is not the bus's own; false: none is left. Slowest first: a servo hears
 * what is sent at a faster rate as single bytes, of which several make the head of a long packet.
 */
static bool next_rate(struct cds_diagnose *diagnose)
{
    while (diagnose->rates_left) {
        diagnose->baud = cds_scan_listed_bauds[--diagnose->rates_left];
        if (diagnose->baud != diagnose->own_baud)
            return true;
    }
    return false;
}

/* Nobody is at this rate, or not the one who is wanted: on to the next, first for that one, then
 * for anyone. */
static void go_elsewhere(struct cds_diagnose *diagnose)
{
    if (diagnose->phase != ELSEWHERE_ANYONE && diagnose->target != CDS_BROADCAST_ID) {
        if (next_rate(diagnose)) {
            enter(diagnose, ELSEWHERE);
            return;
        }
        diagnose->rates_left = CDS_SCAN_LISTED_BAUDS;
    }
    if (diagnose->found_id == CDS_DIAGNOSE_NOBODY && next_rate(diagnose))
        enter(diagnose, ELSEWHERE_ANYONE);
    else
        nobody_is_there(diagnose);
}

static void examine(struct cds_diagnose *diagnose, uint8_t id)
{
    diagnose->target = id;
    diagnose->found_id = id;
    enter(diagnose, KNOCK);
}

/* Are the damaged answers noise, or two servos? Another one may tell. */
static void compare(struct cds_diagnose *diagnose, bool another_is_clean)
{
    find(diagnose, another_is_clean ? CDS_FINDING_DUPLICATE_ID : CDS_FINDING_NOISE);
}

static void seek(struct cds_diagnose *diagnose, uint8_t from_id)
{
    const struct cds_diagnose_tally *total = &diagnose->total;

    diagnose->seek_id = from_id;
    if (from_id == diagnose->target)
        diagnose->seek_id++;
    if (diagnose->seek_id <= CDS_ID_MAX)
        enter(diagnose, SEEK);
    else if (diagnose->purpose == TO_COMPARE)
        compare(diagnose,
                total->damaged >= total->asked - total->asked / 4); // nobody else is there
    else
        go_elsewhere(diagnose);
}

static void knocked(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;

    diagnose->ping = *series;
    if (series->answered || series->damaged > diagnose->late) { // else it was whole in the end
        diagnose->found_id = diagnose->target;
        enter(diagnose, SAME);
    } else if (diagnose->late) {
        diagnose->found_id = diagnose->target;
        find(diagnose, CDS_FINDING_SLOW);
    } else if (diagnose->looked_again) {
        nobody_is_there(diagnose);
    } else {
        diagnose->purpose = TO_TELL;
        enter(diagnose, ANYONE);
    }
}

/* Are answers damaged, and most of those whole but for their beginning? Then it answers before the
 * driver has let go. */
static NOINLINE bool is_too_quick(const struct cds_diagnose_tally *tally)
{
    return tally->cut >= FEW && tally->cut >= tally->asked / 4 &&
           3 * (tally->damaged - tally->cut) <= tally->cut;
}

static void read_the_same(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;

    diagnose->same = *series;
    if (series->silent < series->asked || diagnose->ping.silent >= FEW)
        enter(diagnose, DIFFERING);
    else if (is_too_quick(&diagnose->ping))
        find(diagnose, CDS_FINDING_REPLIES_TOO_EARLY);
    else if (!look_again(diagnose))
        find(diagnose, CDS_FINDING_NO_REPLY_BY_LEVEL);
}

static void read_what_differs(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *total = &diagnose->total, *series = &diagnose->series;
    uint8_t bad = (uint8_t)(total->asked - total->answered);
    uint8_t of_them = (uint8_t)(series->damaged - series->cut);
    uint8_t same = (uint8_t)(bad - (series->asked - series->answered));

    diagnose->differing = *series;
    if (bad < FEW) {
        enter(diagnose, LIMITS);
    } else if (is_too_quick(total)) {
        find(diagnose, CDS_FINDING_REPLIES_TOO_EARLY);
    } else if (same <= FEW && (uint8_t)(of_them + 1) >= series->asked) {
        find(diagnose, CDS_FINDING_DUPLICATE_ID);
    } else if (total->damaged >= total->asked / 2) {
        diagnose->purpose = TO_COMPARE;
        seek(diagnose, 0);
    } else if (!look_again(diagnose)) {
        find(diagnose, CDS_FINDING_NOISE);
    }
}

/* What it says of itself: conditions in its error bits, or values beyond its limits. */
static void judge(struct cds_diagnose *diagnose)
{
    uint8_t voltage = diagnose->feedback[CDS_REG_PRESENT_VOLTAGE - CDS_REG_PRESENT_POSITION];
    uint8_t celsius = diagnose->feedback[CDS_REG_PRESENT_TEMPERATURE - CDS_REG_PRESENT_POSITION];
    uint8_t too_hot = diagnose->limits[CDS_REG_MAX_TEMPERATURE - LIMITS_AT];
    uint8_t lowest = diagnose->limits[CDS_REG_MIN_VOLTAGE - LIMITS_AT];
    uint8_t highest = diagnose->limits[CDS_REG_MAX_VOLTAGE - LIMITS_AT];
    bool known = diagnose->limits_known;

    diagnose->value = (uint16_t)(voltage * SUPPLY_MV);
    if (known && voltage > highest) {
        find(diagnose, CDS_FINDING_HIGH_SUPPLY);
    } else if ((known && voltage < lowest) || diagnose->error & CDS_ERROR_VOLTAGE) {
        find(diagnose, CDS_FINDING_LOW_SUPPLY);
    } else if ((known && celsius > too_hot) || diagnose->error & CDS_ERROR_OVERHEATING) {
        diagnose->value = celsius;
        find(diagnose, CDS_FINDING_OVERHEATED);
    } else {
        diagnose->value = 0;
        find(diagnose,
             diagnose->error & CDS_ERROR_OVERLOAD ? CDS_FINDING_OVERLOADED : CDS_FINDING_OK);
    }
}

static void hurried(struct cds_diagnose *diagnose)
{
    if (diagnose->series.silent < diagnose->series.asked) {
        judge(diagnose);
        return;
    }
    diagnose->value = (uint16_t)(2u * diagnose->limits[0]);
    find(diagnose, CDS_FINDING_SLOW);
}

static void looked_for_anyone(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;

    diagnose->crowd = series->damaged >= FEW;
    if (series->answered)
        enter(diagnose, NAME);
    else if (diagnose->crowd)
        seek(diagnose, 0);
    else
        go_elsewhere(diagnose);
}

static void sought(struct cds_diagnose *diagnose)
{
    diagnose->candidate = diagnose->seek_id;
    if (diagnose->series.answered || diagnose->series.damaged)
        enter(diagnose, NAME);
    else
        seek(diagnose, (uint8_t)(diagnose->seek_id + 1));
}

/* Is the candidate there? One that a crowd's mixed answers have made up is not. */
static void named(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;
    bool was_sought = diagnose->candidate == diagnose->seek_id;

    if ((uint8_t)(series->answered + series->damaged) < FEW) {
        seek(diagnose, was_sought ? (uint8_t)(diagnose->candidate + 1) : 0);
    } else if (diagnose->purpose == TO_COMPARE) {
        compare(diagnose, series->answered == series->asked);
    } else if (diagnose->purpose == TO_EXAMINE) {
        examine(diagnose, diagnose->candidate);
    } else if (diagnose->candidate == diagnose->target) { // now it answers
        look_again(diagnose);
    } else {
        diagnose->found_id = diagnose->candidate;
        go_elsewhere(diagnose);
    }
}

static void looked_elsewhere(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;
    bool anyone = diagnose->phase == ELSEWHERE_ANYONE;

    if (!series->answered && !(anyone && series->damaged == series->asked)) {
        go_elsewhere(diagnose);
        return;
    }
    diagnose->found_baud = diagnose->baud;
    diagnose->found_id = !anyone            ? diagnose->target
                         : series->answered ? diagnose->candidate
                                            : CDS_DIAGNOSE_NOBODY;
    find(diagnose, CDS_FINDING_OTHER_RATE);
}

static void series_ended(struct cds_diagnose *diagnose)
{
    enum cds_finding found;

    gather(diagnose);
    found = trouble(diagnose);
    if (found != CDS_FINDING_NONE) {
        find(diagnose, found);
        return;
    }
    switch (diagnose->phase) {
    case KNOCK: knocked(diagnose); break;
    case SAME: read_the_same(diagnose); break;
    case DIFFERING: read_what_differs(diagnose); break;
    case LIMITS:
        diagnose->limits_known = diagnose->series.answered != 0;
        if (diagnose->return_delay_us < CDS_RETURN_DELAY_MAX_US)
            enter(diagnose, HASTE);
        else
            judge(diagnose);
        break;
    case HASTE: hurried(diagnose); break;
    case ANYONE: looked_for_anyone(diagnose); break;
    case SEEK: sought(diagnose); break;
    case NAME: named(diagnose); break;
    case WAKE: enter(diagnose, KNOCK); break;
    default: looked_elsewhere(diagnose);
    }
}

/* ---- from one to the next ---- */

static void start(struct cds_diagnose *diagnose)
{
    struct cds_bus *bus = diagnose->bus;

    if (bus->request)
        return;
    diagnose->return_delay_us = cds_operation_take(bus);
    diagnose->repeats = bus->repeats;
    cds_bus_set_repeats(bus, 0); // each question counts
    enter(diagnose, SETTLE);
    rest(diagnose, SETTLE_US, CDS_RING_SIZE);
}

static void give_back(struct cds_diagnose *diagnose)
{
    if (!tuned(diagnose))
        return;
    cds_bus_set_return_delay(diagnose->bus, diagnose->return_delay_us);
    cds_bus_set_repeats(diagnose->bus, diagnose->repeats);
    diagnose->result = diagnose->finding == CDS_FINDING_NONE ? CDS_CANCELLED : CDS_OK;
}

static void listen(struct cds_diagnose *diagnose)
{
    uint8_t head = diagnose->bus->link.rx.head;

    diagnose->unasked = (uint16_t)(diagnose->unasked + (uint8_t)(head - diagnose->head));
    diagnose->head = head;
}

static bool is_over(const struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;

    if ((diagnose->phase == LIMITS || diagnose->phase == WAKE) && series->answered)
        return true;
    return series->asked == wanted[diagnose->phase] || series->busy >= FEW;
}

/* A pause is over, or there was none. */
static void go_on(struct cds_diagnose *diagnose)
{
    switch (diagnose->phase) {
    case SETTLE:
        enter(diagnose, LISTEN);
        rest(diagnose, LISTEN_US, 0);
        diagnose->head = diagnose->bus->link.rx.head;
        break;
    case LISTEN:
        gather(diagnose);
        listened(diagnose);
        break;
    case GIVE_BACK: give_back(diagnose); break;
    default:
        if (is_over(diagnose))
            series_ended(diagnose);
        else if (tuned(diagnose))
            ask(diagnose);
    }
}

static void poll_in_turn(struct cds_diagnose *diagnose)
{
    if (diagnose->phase == START) {
        if (diagnose->aborted)
            diagnose->result = CDS_CANCELLED;
        else
            start(diagnose);
        return;
    }
    if (diagnose->aborted)
        diagnose->phase = GIVE_BACK;
    if (diagnose->phase == LISTEN)
        listen(diagnose);
    if (diagnose->phase == GIVE_BACK ||
        cds_port_now_us() - diagnose->since_us >= diagnose->pause_us)
        go_on(diagnose);
}

DECLARED_NOINLINE(cds_diagnose_poll);

enum cds_result cds_diagnose_poll(struct cds_diagnose *diagnose)
{
    OPTIMIZER_BARRIER(diagnose);
    if (diagnose->result != CDS_PENDING)
        return (enum cds_result)diagnose->result;
    if (diagnose->phase != START && !cds_operation_has(diagnose->bus)) {
        diagnose->request->skips_rest = false;
        diagnose->result = CDS_CANCELLED; // the bus is somebody else's
        return CDS_CANCELLED;
    }
    if (diagnose->in_flight) {
        if (diagnose->request->result == CDS_PENDING)
            return CDS_PENDING;
        diagnose->in_flight = 0;
        diagnose->request->skips_rest = false;
        if (diagnose->request->result == CDS_CANCELLED)
            cds_diagnose_abort(diagnose);
        else
            exchange_ended(diagnose);
    }
    poll_in_turn(diagnose);
    return (enum cds_result)diagnose->result;
}
