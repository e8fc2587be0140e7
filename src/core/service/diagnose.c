/* SPDX-License-Identifier: MIT */
/* Series of PINGs and READs, and what their replies tell; see diagnose.h and docs/diagnose.md. */
#include "cds55xx/diagnose.h"

#include <string.h>

#include "bus/line_internal.h"  // GATE_PERMIT
#include "bus/steps_internal.h" // cds_steps_poll()
#include "cds55xx/scan.h"       // cds_scan_listed_baud_regs
#include "cds55xx/servo.h"      // cds_servo_ping(), cds_servo_read()
#include "compiler.h"           // NOINLINE
#include "flash.h"              // CDS_FLASH

#define LISTEN_US   50000u
#define SETTLE_US   2000u  // before that, with 64 byte times: replies to earlier packets pass
#define PAUSE_US    1000u  // after a transaction, with 8 byte times: a second reply comes
#define LATE_US     12000u // after a PING of the target without a good reply: a late one may come
#define NOISE       4      // unrequested bytes; a good bus that loses a reply has fewer
#define FEW         2      // of anything that may happen once on a good bus
#define SUPPLY_MV   100u   // unit of the registers
#define VARYING_LEN 8      // bytes from PRESENT_POSITION to PRESENT_TEMPERATURE
#define LIMITS_AT   CDS_REG_RETURN_DELAY
#define LIMITS_LEN  CDS_DIAGNOSE_REPLY_SIZE // to TORQUE_ENABLE
/* Longer than the longest reply, and than a packet and the two header bytes after it. */
#define HEARD_MAX (CDS_PACKET_SIZE(LIMITS_LEN) + 1)

_Static_assert(LIMITS_AT + LIMITS_LEN == CDS_REG_TORQUE_ENABLE + 1, "the last register");

enum diagnose_phase {
    START,        // until the bus is idle
    SETTLE,       // stale replies pass
    LISTEN,       // to the line, without a packet of ours
    PROBE,        // PING of the target
    READ_SAME,    // a register that is equal in two servos with one ID: the ID
    READ_VARYING, // registers in which they differ: position to temperature
    READ_LIMITS,  // return delay, limits of temperature, voltage and torque, torque on or off
    CHECK_DELAY,  // PING with the return delay for which other requests wait
    PROBE_ANY,    // broadcast PING
    SEEK,         // PING of one ID after the other
    NAME,         // PING of the candidate
    RESYNC,       // PING of the target until it hears again
    TRY_RATE,     // PING of the target at another rate
    TRY_RATE_ANY, // broadcast PING at another rate
} __attribute__((packed));

/* Why a candidate is looked for. TO_COMPARE: if the replies of another servo are clean, damage of
 * the target comes from a second servo with its ID, not from noise. */
enum diagnose_purpose { TO_EXAMINE, TO_TELL_OTHER_ID, TO_COMPARE } __attribute__((packed));

/* Each series: how many transactions, and the registers of a READ; length 0: PING. A deaf servo
 * hears again after 43 PINGs of 6 bytes: more bytes than any LENGTH. */
static const CDS_FLASH struct {
    uint8_t count, address, length;
} series_of[] = {
    [PROBE] = {.count = 4},
    [READ_SAME] = {6, CDS_REG_ID, 1},
    [READ_VARYING] = {6, CDS_REG_PRESENT_POSITION, VARYING_LEN},
    [READ_LIMITS] = {3, LIMITS_AT, LIMITS_LEN},
    [CHECK_DELAY] = {.count = 3},
    [PROBE_ANY] = {.count = 3},
    [SEEK] = {.count = 1},
    [NAME] = {.count = 3},
    [RESYNC] = {.count = 43},
    [TRY_RATE] = {.count = 2},
    [TRY_RATE_ANY] = {.count = 2},
};

enum cds_result cds_diagnose_begin(struct cds_diagnose *diagnose,
                                   const struct cds_diagnose_config *config)
{
    struct cds_bus *bus = config->bus;
    enum cds_result result = cds_steps_check_exclusive(
        bus, config->request, CDS_DIAGNOSE_PACKET_SIZE, CDS_DIAGNOSE_REPLY_SIZE);

    if (config->id > CDS_BROADCAST_ID)
        result = CDS_BAD_ARGUMENT;
    if (result != CDS_OK)
        return result;
    *diagnose = (struct cds_diagnose){
        .target = config->id,
        .found_id = CDS_NO_ID,
        .found_baud_reg = bus->baud_reg,
        .known_baud_reg = bus->baud_reg,
        .rates_left = CDS_SCAN_LISTED_BAUDS + 1,
        .phase = START,
    };
    cds_steps_begin_exclusive(&diagnose->steps, bus, config->request);
    return CDS_OK;
}

void cds_diagnose_abort(struct cds_diagnose *diagnose)
{
    cds_steps_abort(&diagnose->steps);
}

static NOINLINE void pause_for(struct cds_diagnose *diagnose, uint16_t us, uint8_t bytes)
{
    diagnose->since_us = cds_port_now_us();
    diagnose->pause_us = us + (uint32_t)bytes * diagnose->steps.bus->byte_time_us;
}

static void enter(struct cds_diagnose *diagnose, enum diagnose_phase phase)
{
    diagnose->phase = (uint8_t)phase;
    diagnose->series = (struct cds_diagnose_tally){0};
    cds_bus_stats(diagnose->steps.bus, &diagnose->base);
}

static void conclude(struct cds_diagnose *diagnose, enum cds_finding finding)
{
    diagnose->finding = (uint8_t)finding;
    if (finding == CDS_FINDING_DUPLICATE_ID && diagnose->found_id == CDS_NO_ID)
        diagnose->found_id = diagnose->steps.bus->last_id;
    cds_steps_end(&diagnose->steps, CDS_OK);
}

static bool asks_any(const struct cds_diagnose *diagnose)
{
    return diagnose->phase == PROBE_ANY || diagnose->phase == TRY_RATE_ANY;
}

static uint8_t id_of(const struct cds_diagnose *diagnose)
{
    if (asks_any(diagnose))
        return CDS_BROADCAST_ID;
    if (diagnose->phase == SEEK)
        return diagnose->seek_id;
    return diagnose->phase == NAME ? diagnose->candidate : diagnose->target;
}

/* ---- one transaction ---- */

static enum cds_result ask(struct cds_diagnose *diagnose)
{
    struct cds_steps *steps = &diagnose->steps;
    struct cds_bus *bus = steps->bus;
    struct cds_request *request = steps->request;
    uint8_t phase = diagnose->phase, id = id_of(diagnose), length = series_of[phase].length;
    enum cds_result result;

    if (!cds_steps_set_baud(steps, phase >= TRY_RATE ? diagnose->baud_reg : steps->lock.baud_reg))
        return CDS_BUSY;
    if (phase == CHECK_DELAY) {
        if (cds_bus_is_resting(bus))
            return CDS_BUSY; // the PING would wait, and then get the bus's own return delay
        cds_bus_set_return_delay(bus, diagnose->wait_us);
    }
    diagnose->position = cds_ring_end(&bus->link.rx);
    request->no_retry = true;
    request->ignores_servo_state = true;
    request->ignores_stale = phase == SEEK; // a stale reply comes from another ID
    result = length ? cds_servo_read(bus, request, id, series_of[phase].address, length)
                    : cds_servo_ping(bus, request, id);
    if (phase == CHECK_DELAY) // the last series; this packet keeps the delay that it began with
        cds_bus_set_return_delay(bus, steps->return_delay_us);
    return result;
}

/* Bytes that came since the packet in flight was submitted. */
static uint8_t heard_count(const struct cds_diagnose *diagnose)
{
    return cds_ring_distance(diagnose->position, cds_ring_end(&diagnose->steps.bus->link.rx));
}

/* Copies the first bytes heard, HEARD_MAX or `count`. The bytes stay in the ring until 64 more
 * bytes come, even if the bus has released them. */
static void copy_heard(const struct cds_diagnose *diagnose, uint8_t *to, uint8_t count)
{
    for (uint8_t i = 0; i < count && i < HEARD_MAX; i++)
        to[i] = cds_ring_at(&diagnose->steps.bus->link.rx, cds_ring_after(diagnose->position, i));
}

/* True if the `count` bytes heard begin with an echo: the last bytes of the packet, with a reply or
 * nothing after them. A whole PING is no echo: it is also the reply of a servo with a voltage
 * error. Nor is the end of a PING, if it is that reply without its first bytes. */
static bool is_echo(const struct cds_diagnose *diagnose, const uint8_t *heard, uint8_t count)
{
    const struct cds_packet *packet = &diagnose->steps.request->packet;
    uint8_t longest = (uint8_t)(packet->size - (diagnose->phase == PROBE));

    for (uint8_t i = 1; i <= longest && i <= count; i++)
        if (memcmp(heard, packet->bytes + packet->size - i, i) == 0 &&
            (i == count ||
             (count - i >= 2 && heard[i] == CDS_HEADER && heard[i + 1] == CDS_HEADER)))
            return true;
    return false;
}

/* True if the `count` bytes heard are the reply due without its first bytes, up to LENGTH. LENGTH
 * and checksum prove that: noise or two servos would have changed them. Without ERROR nothing is
 * proven. */
static bool is_cut(const struct cds_diagnose *diagnose, const uint8_t *heard, uint8_t count)
{
    uint8_t id = id_of(diagnose);
    uint8_t length = (uint8_t)(diagnose->steps.request->reply_parameters + CDS_LENGTH_MIN);
    uint8_t head[CDS_AT_ERROR] = {CDS_HEADER, CDS_HEADER, id, length};
    uint8_t lost = (uint8_t)(CDS_AT_ERROR + length - count);
    uint8_t left = (uint8_t)(CDS_AT_ERROR - lost); // bytes of the head that were heard
    uint8_t sum = (uint8_t)(id + length);

    if (count >= CDS_AT_ERROR + length || lost > CDS_AT_ERROR ||
        memcmp(heard, head + lost, left) != 0)
        return false;
    for (uint8_t i = left; i < count; i++)
        sum = (uint8_t)(sum + heard[i]);
    return sum == UINT8_MAX; // a checksum is the complement of the sum
}

static void add_tally(struct cds_diagnose_tally *sum, const struct cds_diagnose_tally *tally)
{
    for (uint8_t i = 0; i < sizeof *sum; i++)
        ((uint8_t *)sum)[i] = (uint8_t)(((uint8_t *)sum)[i] + ((const uint8_t *)tally)[i]);
}

static void keep_reply(struct cds_diagnose *diagnose)
{
    const struct cds_request *request = diagnose->steps.request;
    const uint8_t *reply = request->reply;

    if (asks_any(diagnose))
        diagnose->candidate = request->id;
    if (diagnose->phase == READ_VARYING) {
        diagnose->error = request->error;
        diagnose->voltage = reply[CDS_REG_PRESENT_VOLTAGE - CDS_REG_PRESENT_POSITION];
        diagnose->temperature = reply[CDS_REG_PRESENT_TEMPERATURE - CDS_REG_PRESENT_POSITION];
    }
    if (diagnose->phase == READ_LIMITS)
        memcpy(diagnose->limits, reply, LIMITS_LEN);
}

/* How a transaction ended, with `count` bytes heard. */
static struct cds_diagnose_tally tally_of(const struct cds_diagnose *diagnose,
                                          enum cds_result result, uint8_t count)
{
    struct cds_diagnose_tally tally = {.asked = 1};
    uint8_t heard[HEARD_MAX];

    copy_heard(diagnose, heard, count);
    tally.cut = is_cut(diagnose, heard, count);
    if (!tally.cut || diagnose->phase != PROBE)
        tally.echoed = is_echo(diagnose, heard, count);
    if (result == CDS_LINE_BUSY)
        tally.busy = 1;
    else if (result == CDS_OK)
        tally.answered = 1;
    else if (result != CDS_TIMEOUT || (count && !tally.echoed))
        tally.damaged = 1;
    else
        tally.silent = 1;
    return tally;
}

static void transaction_ended(void *operation, enum cds_result result)
{
    struct cds_diagnose *diagnose = (struct cds_diagnose *)operation;
    struct cds_diagnose_tally tally;
    uint8_t count = heard_count(diagnose);

    if (!diagnose->steps.is_submitted || result == CDS_CANCELLED) {
        cds_steps_end(&diagnose->steps, result);
        return;
    }
    tally = tally_of(diagnose, result, count);
    diagnose->transactions++;
    add_tally(&diagnose->series, &tally);
    if (diagnose->phase <= READ_VARYING)
        add_tally(&diagnose->total, &tally);
    if (result == CDS_OK)
        keep_reply(diagnose);
    if (diagnose->phase != SEEK || count || result != CDS_TIMEOUT)
        pause_for(diagnose, tally.answered || diagnose->phase != PROBE ? PAUSE_US : LATE_US, 8);
}

/* ---- what follows from a series ---- */

static NOINLINE void add(uint16_t *sum, uint16_t now, uint16_t base)
{
    *sum = (uint16_t)(*sum + now - base);
}

/* Adds what the stats have counted since the series began. */
static void add_stats(struct cds_diagnose *diagnose)
{
    const struct cds_stats *base = &diagnose->base;
    struct cds_stats now;

    cds_bus_stats(diagnose->steps.bus, &now);
    add(&diagnose->unexpected_packets, now.unexpected_packets, base->unexpected_packets);
    add(&diagnose->echo_errors, now.echo_errors, base->echo_errors);
    add(&diagnose->overruns, now.overruns, base->overruns);
    if (diagnose->steps.bus->last_id != CDS_BROADCAST_ID) { // several servos may answer a broadcast
        add(&diagnose->duplicate_replies, now.duplicate_replies, base->duplicate_replies);
        add(&diagnose->stale_replies, now.stale_replies, base->stale_replies);
    }
    if (diagnose->phase == LISTEN) // damaged bytes are counted, not stored
        add(&diagnose->unrequested_bytes, now.framing_errors, base->framing_errors);
}

/* A cause that makes further transactions useless, or NONE. Whole echoes of PING pass for replies,
 * so READ has to show DUPLICATE_ID. */
static NOINLINE enum cds_finding early_finding(const struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;
    uint8_t phase = diagnose->phase;
    bool is_low = cds_bus_line(diagnose->steps.bus) == CDS_BUS_LINE_FAULT;
    bool has_duplicates = diagnose->duplicate_replies >= FEW;
    bool has_others = diagnose->unexpected_packets >= FEW;

    if (series->busy >= FEW)
        return is_low           ? CDS_FINDING_LINE_LOW
               : has_duplicates ? CDS_FINDING_DUPLICATE_ID
               : has_others     ? CDS_FINDING_COLLISION
                                : CDS_FINDING_BABBLE;
    if ((phase == PROBE || phase == READ_SAME || phase == PROBE_ANY) &&
        series->echoed == series->asked)
        return CDS_FINDING_ECHO;
    if (diagnose->echo_errors >= FEW ||
        (has_others && (phase == READ_SAME || phase == READ_VARYING)))
        return CDS_FINDING_COLLISION;
    if (diagnose->unrequested_bytes >= NOISE)
        return CDS_FINDING_NOISE;
    if (diagnose->overruns)
        return CDS_FINDING_BYTES_LOST;
    return has_duplicates && phase != PROBE && phase != RESYNC ? CDS_FINDING_DUPLICATE_ID
                                                               : CDS_FINDING_NONE;
}

/* Examines the target a second time. Returns false if that was done. One damaged LENGTH makes a
 * servo deaf for up to 255 bytes, so one accident may spoil a whole examination. A servo that has
 * answered before is resynchronised first, or the same accident would spoil the second one. */
static bool look_again(struct cds_diagnose *diagnose)
{
    bool is_deaf = diagnose->series.silent && diagnose->found_id == diagnose->target;

    if (diagnose->has_looked_again)
        return false;
    diagnose->has_looked_again = true;
    diagnose->total = (struct cds_diagnose_tally){0};
    enter(diagnose, is_deaf ? RESYNC : PROBE);
    return true;
}

static void conclude_silence(struct cds_diagnose *diagnose)
{
    if (diagnose->target != CDS_BROADCAST_ID && look_again(diagnose))
        return;
    if (diagnose->found_id != CDS_NO_ID)
        conclude(diagnose, CDS_FINDING_OTHER_ID);
    else
        conclude(diagnose, diagnose->hears_crowd ? CDS_FINDING_NOISE : CDS_FINDING_SILENCE);
}

/* The next rate that is not the bus's own: the known one, then the listed ones; false: none is
 * left. Slowest first: a servo hears bytes of a faster rate as single bytes, of which several make
 * the head of a long packet. */
static bool next_rate(struct cds_diagnose *diagnose)
{
    while (diagnose->rates_left) {
        diagnose->baud_reg = --diagnose->rates_left == CDS_SCAN_LISTED_BAUDS
                                 ? diagnose->known_baud_reg
                                 : cds_scan_listed_baud_regs[diagnose->rates_left];
        if (diagnose->baud_reg != diagnose->steps.lock.baud_reg)
            return true;
    }
    return false;
}

/* The target is not at this rate: to the next one, first for the target, then for any servo. */
static void try_next_rate(struct cds_diagnose *diagnose)
{
    if (diagnose->phase != TRY_RATE_ANY && diagnose->target != CDS_BROADCAST_ID) {
        if (next_rate(diagnose)) {
            enter(diagnose, TRY_RATE);
            return;
        }
        diagnose->rates_left = CDS_SCAN_LISTED_BAUDS;
    }
    if (diagnose->found_id == CDS_NO_ID && next_rate(diagnose))
        enter(diagnose, TRY_RATE_ANY);
    else
        conclude_silence(diagnose);
}

static void seek(struct cds_diagnose *diagnose, uint8_t from_id)
{
    const struct cds_diagnose_tally *total = &diagnose->total;

    diagnose->seek_id = from_id;
    if (from_id == diagnose->target)
        diagnose->seek_id++;
    if (diagnose->seek_id <= CDS_ID_MAX)
        enter(diagnose, SEEK);
    else if (diagnose->purpose == TO_COMPARE) // there is no other servo
        conclude(diagnose, total->damaged >= total->asked - total->asked / 4
                               ? CDS_FINDING_DUPLICATE_ID
                               : CDS_FINDING_NOISE);
    else
        try_next_rate(diagnose);
}

static void probe_ended(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;

    diagnose->probe = *series;
    if (series->answered || series->damaged > diagnose->stale_replies) {
        diagnose->found_id = diagnose->target;
        enter(diagnose, READ_SAME);
    } else if (diagnose->stale_replies) { // all that was damaged became whole after the deadline
        diagnose->found_id = diagnose->target;
        conclude(diagnose, CDS_FINDING_SLOW);
    } else if (diagnose->has_looked_again) {
        conclude_silence(diagnose);
    } else {
        diagnose->purpose = TO_TELL_OTHER_ID;
        enter(diagnose, PROBE_ANY);
    }
}

/* True if replies are damaged and most of these are only cut: the servo answers before the driver
 * has let go. */
static NOINLINE bool is_too_early(const struct cds_diagnose_tally *tally)
{
    return tally->cut >= FEW && tally->cut >= tally->asked / 4 &&
           3 * (tally->damaged - tally->cut) <= tally->cut;
}

static void read_same_ended(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;

    diagnose->same = *series;
    if (series->silent < series->asked || diagnose->probe.silent >= FEW)
        enter(diagnose, READ_VARYING);
    else if (is_too_early(&diagnose->probe))
        conclude(diagnose, CDS_FINDING_REPLIES_TOO_EARLY);
    else if (!look_again(diagnose))
        conclude(diagnose, CDS_FINDING_NO_REPLY_BY_LEVEL);
}

static void read_varying_ended(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *total = &diagnose->total, *series = &diagnose->series;
    uint8_t bad = (uint8_t)(total->asked - total->answered);
    uint8_t bad_before = (uint8_t)(bad - (series->asked - series->answered));
    uint8_t damaged = (uint8_t)(series->damaged - series->cut);

    diagnose->varying = *series;
    if (bad < FEW) {
        enter(diagnose, READ_LIMITS);
    } else if (diagnose->stale_replies >= FEW) {
        conclude(diagnose, CDS_FINDING_SLOW);
    } else if (is_too_early(total)) {
        conclude(diagnose, CDS_FINDING_REPLIES_TOO_EARLY);
    } else if (bad_before <= FEW && (uint8_t)(damaged + 1) >= series->asked) {
        conclude(diagnose, CDS_FINDING_DUPLICATE_ID);
    } else if (total->damaged >= total->asked / 2) {
        diagnose->purpose = TO_COMPARE;
        seek(diagnose, 0);
    } else if (!look_again(diagnose)) {
        conclude(diagnose, CDS_FINDING_NOISE);
    }
}

/* True if MAX_TORQUE is 0. */
static bool has_no_torque(const uint8_t *limits)
{
    return (limits[CDS_REG_MAX_TORQUE - LIMITS_AT] | limits[CDS_REG_MAX_TORQUE + 1 - LIMITS_AT]) ==
           0;
}

/* What the servo reports: conditions in its error bits, or values beyond its limits. */
static void judge_values(struct cds_diagnose *diagnose)
{
    uint8_t voltage = diagnose->voltage, error = diagnose->error;
    const uint8_t *limits = diagnose->limits;
    bool known = diagnose->has_limits;

    diagnose->value = (uint16_t)(voltage * SUPPLY_MV);
    if (known && voltage > limits[CDS_REG_MAX_VOLTAGE - LIMITS_AT]) {
        conclude(diagnose, CDS_FINDING_HIGH_SUPPLY);
    } else if ((known && voltage < limits[CDS_REG_MIN_VOLTAGE - LIMITS_AT]) ||
               error & CDS_ERROR_VOLTAGE) {
        conclude(diagnose, CDS_FINDING_LOW_SUPPLY);
    } else if ((known && diagnose->temperature > limits[CDS_REG_MAX_TEMPERATURE - LIMITS_AT]) ||
               error & CDS_ERROR_OVERHEATING) {
        diagnose->value = diagnose->temperature;
        conclude(diagnose, CDS_FINDING_OVERHEATED);
    } else {
        diagnose->value = 0;
        conclude(diagnose, error & CDS_ERROR_OVERLOAD       ? CDS_FINDING_OVERLOADED
                           : known && has_no_torque(limits) ? CDS_FINDING_NO_TORQUE
                                                            : CDS_FINDING_OK);
    }
}

/* Two servos of one ID that measure the same still differ in limits or torque: then all READs are
 * damaged. A bus with a permit waits only for the servo's own return delay. */
static void read_limits_ended(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;

    diagnose->has_limits = series->answered != 0;
    diagnose->value = (uint16_t)(2u * diagnose->limits[CDS_REG_RETURN_DELAY - LIMITS_AT]);
    diagnose->wait_us = diagnose->steps.return_delay_us;
    if (series->answered && diagnose->steps.bus->gate & GATE_PERMIT &&
        diagnose->value < diagnose->wait_us)
        diagnose->wait_us = diagnose->value;
    if ((uint8_t)(series->damaged - series->cut) == series_of[READ_LIMITS].count)
        conclude(diagnose, CDS_FINDING_DUPLICATE_ID);
    else if (diagnose->wait_us < CDS_RETURN_DELAY_MAX_US)
        enter(diagnose, CHECK_DELAY);
    else
        judge_values(diagnose);
}

static void check_delay_ended(struct cds_diagnose *diagnose)
{
    if (diagnose->series.answered)
        judge_values(diagnose);
    else
        conclude(diagnose, CDS_FINDING_SLOW);
}

static void probe_any_ended(struct cds_diagnose *diagnose)
{
    diagnose->hears_crowd = diagnose->series.damaged >= FEW;
    if (diagnose->series.answered)
        enter(diagnose, NAME);
    else if (diagnose->hears_crowd)
        seek(diagnose, 0);
    else
        try_next_rate(diagnose);
}

static void seek_ended(struct cds_diagnose *diagnose)
{
    diagnose->candidate = diagnose->seek_id;
    if (diagnose->series.answered || diagnose->series.damaged)
        enter(diagnose, NAME);
    else
        seek(diagnose, (uint8_t)(diagnose->seek_id + 1));
}

/* Checks that the candidate exists: mixed replies of several servos can look like a reply of it. */
static void name_ended(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;
    uint8_t candidate = diagnose->candidate;

    if ((uint8_t)(series->answered + series->damaged) < FEW) {
        seek(diagnose, candidate == diagnose->seek_id ? (uint8_t)(candidate + 1) : 0);
    } else if (diagnose->purpose == TO_COMPARE) {
        conclude(diagnose,
                 series->answered == series->asked ? CDS_FINDING_DUPLICATE_ID : CDS_FINDING_NOISE);
    } else if (diagnose->purpose == TO_EXAMINE) {
        diagnose->target = diagnose->found_id = candidate;
        enter(diagnose, PROBE);
    } else if (candidate == diagnose->target) { // now it answers
        look_again(diagnose);
    } else {
        diagnose->found_id = candidate;
        try_next_rate(diagnose);
    }
}

static void try_rate_ended(struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;
    bool any = asks_any(diagnose);

    if (!series->answered && !(any && series->damaged == series->asked)) {
        try_next_rate(diagnose);
        return;
    }
    diagnose->found_baud_reg = diagnose->baud_reg;
    diagnose->found_id = !any               ? diagnose->target
                         : series->answered ? diagnose->candidate
                                            : CDS_NO_ID;
    conclude(diagnose, CDS_FINDING_OTHER_RATE);
}

static void series_ended(struct cds_diagnose *diagnose)
{
    enum cds_finding found;

    add_stats(diagnose);
    found = early_finding(diagnose);
    if (found != CDS_FINDING_NONE) {
        conclude(diagnose, found);
        return;
    }
    switch (diagnose->phase) {
    case PROBE: probe_ended(diagnose); break;
    case READ_SAME: read_same_ended(diagnose); break;
    case READ_VARYING: read_varying_ended(diagnose); break;
    case READ_LIMITS: read_limits_ended(diagnose); break;
    case CHECK_DELAY: check_delay_ended(diagnose); break;
    case PROBE_ANY: probe_any_ended(diagnose); break;
    case SEEK: seek_ended(diagnose); break;
    case NAME: name_ended(diagnose); break;
    case RESYNC: enter(diagnose, PROBE); break;
    default: try_rate_ended(diagnose);
    }
}

static bool is_series_over(const struct cds_diagnose *diagnose)
{
    const struct cds_diagnose_tally *series = &diagnose->series;

    if ((diagnose->phase == READ_LIMITS || diagnose->phase == RESYNC) && series->answered)
        return true;
    return series->asked == series_of[diagnose->phase].count || series->busy >= FEW;
}

/* ---- before the first series ---- */

static void enter_settle(struct cds_diagnose *diagnose)
{
    if (diagnose->steps.bus->request)
        return; // waits for requests that were submitted before the diagnosis
    enter(diagnose, SETTLE);
    pause_for(diagnose, SETTLE_US, CDS_RING_SIZE);
}

static void enter_listen(struct cds_diagnose *diagnose)
{
    enter(diagnose, LISTEN);
    pause_for(diagnose, LISTEN_US, 0);
    diagnose->position = cds_ring_end(&diagnose->steps.bus->link.rx);
}

static void count_unrequested(struct cds_diagnose *diagnose)
{
    uint8_t heard = heard_count(diagnose);

    diagnose->unrequested_bytes = (uint16_t)(diagnose->unrequested_bytes + heard);
    diagnose->position = cds_ring_after(diagnose->position, heard);
}

static void listen_ended(struct cds_diagnose *diagnose)
{
    add_stats(diagnose);
    if (cds_bus_line(diagnose->steps.bus) == CDS_BUS_LINE_FAULT)
        conclude(diagnose, CDS_FINDING_LINE_LOW);
    else if (diagnose->duplicate_replies >= FEW)
        conclude(diagnose, CDS_FINDING_DUPLICATE_ID);
    else if (diagnose->unexpected_packets)
        conclude(diagnose, CDS_FINDING_COLLISION);
    else
        enter(diagnose, diagnose->target == CDS_BROADCAST_ID ? PROBE_ANY : PROBE);
}

static enum cds_result send(void *operation)
{
    struct cds_diagnose *diagnose = (struct cds_diagnose *)operation;

    if (diagnose->phase == LISTEN)
        count_unrequested(diagnose);
    if (cds_port_now_us() - diagnose->since_us < diagnose->pause_us)
        return CDS_BUSY;
    if (diagnose->phase == START)
        enter_settle(diagnose);
    else if (diagnose->phase == SETTLE)
        enter_listen(diagnose);
    else if (diagnose->phase == LISTEN)
        listen_ended(diagnose);
    else if (is_series_over(diagnose))
        series_ended(diagnose);
    else
        return ask(diagnose);
    return CDS_BUSY;
}

enum cds_result cds_diagnose_poll(struct cds_diagnose *diagnose)
{
    return cds_steps_poll(&diagnose->steps, diagnose, send, transaction_ended);
}
