/* Who is on the bus; see scan.h. */
#include "cds55xx/scan.h"

#include <stddef.h>

#include "cds55xx/servo.h"     // cds_servo_ping(), cds_servo_read()
#include "compiler.h"          // OPTIMIZER_BARRIER(), NOINLINE, DECLARED_NOINLINE()
#include "service/operation.h" // cds_operation_take()

const uint8_t cds_scan_listed_bauds[CDS_SCAN_LISTED_BAUDS] = {1, 3, 7, 16, 34, 103};

#define DETAILS (CDS_REG_BAUD_RATE - CDS_REG_MODEL_NUMBER + 1) // bytes read

enum scan_phase {
    CHECK,    // the arguments
    TUNE,     // the bus to the rate that is next
    ASK,      // PING is next
    ASKED,    // ... and in flight
    READ,     // the details are next
    READING,  // ... and in flight
    GIVE_BACK // the bus its own rate
};

void cds_scan_begin(struct cds_scan *scan, struct cds_bus *bus, struct cds_request *request,
                    struct cds_scan_found *found, uint8_t room)
{
    // begun anew while it was under way: still to be given back is what it took then
    bool took = scan->result == CDS_PENDING && scan->phase != CHECK && scan->bus == bus &&
                cds_operation_has(bus);

    *scan = (struct cds_scan){
        .bus = bus,
        .request = request,
        .found = found,
        .room = room,
        .bauds = cds_scan_listed_bauds,
        .baud_count = CDS_SCAN_LISTED_BAUDS,
        .last_id = CDS_ID_MAX,
        .phase = CHECK,
        .result = CDS_PENDING,
        .took = took,
        .own_baud = scan->own_baud,
        .return_delay_us = scan->return_delay_us,
    };
}

void cds_scan_set_ids(struct cds_scan *scan, uint8_t first, uint8_t last)
{
    scan->first_id = first;
    scan->last_id = last;
}

void cds_scan_set_bauds(struct cds_scan *scan, const uint8_t *bauds, uint8_t count)
{
    scan->bauds = bauds;
    scan->baud_count = bauds ? count : 0;
}

void cds_scan_set_rescue(struct cds_scan *scan)
{
    scan->bauds = NULL;
    scan->baud_count = CDS_BAUD_MAX + 1;
}

void cds_scan_set_details(struct cds_scan *scan)
{
    scan->with_details = 1;
}

void cds_scan_abort(struct cds_scan *scan)
{
    scan->aborted = 1;
}

static uint8_t baud_of(const struct cds_scan *scan, uint8_t index)
{
    return scan->bauds ? scan->bauds[index] : index;
}

static enum cds_result check(const struct cds_scan *scan)
{
    if (scan->bus->byte_time_us == 0 || scan->first_id > scan->last_id ||
        scan->last_id > CDS_ID_MAX || scan->baud_count == 0)
        return CDS_BAD_ARGUMENT;
    for (uint8_t i = 0; i < scan->baud_count; i++)
        if (baud_of(scan, i) > CDS_BAUD_MAX)
            return CDS_BAD_ARGUMENT;
    return scan->request->packet.capacity < CDS_PACKET_SIZE(2) ? CDS_NO_ROOM : CDS_PENDING;
}

static void start(struct cds_scan *scan)
{
    uint16_t return_delay_us;

    scan->result = (uint8_t)check(scan);
    if (scan->result != CDS_PENDING)
        return;
    scan->id = scan->first_id;
    scan->total = (uint16_t)((uint16_t)(scan->last_id - scan->first_id + 1) * scan->baud_count);
    // who they are is not known, still less how long they wait
    return_delay_us = cds_operation_take(scan->bus);
    if (!scan->took) {
        scan->own_baud = scan->bus->baud;
        scan->return_delay_us = return_delay_us;
    }
    scan->phase = scan->aborted ? GIVE_BACK : TUNE;
}

static void next(struct cds_scan *scan)
{
    scan->asked++;
    if (scan->aborted) {
        scan->phase = GIVE_BACK;
    } else if (scan->id < scan->last_id) {
        scan->id++;
        scan->phase = ASK;
    } else {
        scan->id = scan->first_id;
        scan->baud_index++;
        scan->phase = scan->baud_index < scan->baud_count ? TUNE : GIVE_BACK;
    }
}

static void asked(struct cds_scan *scan)
{
    uint8_t result = scan->request->result;

    scan->request->skips_rest = false;
    if (result == CDS_CANCELLED) {
        scan->aborted = 1;
        scan->phase = GIVE_BACK;
        return;
    }
    if (result == CDS_LINE_BUSY) { // whoever is there cannot be asked
        scan->line_busy = 1;
        scan->phase = GIVE_BACK;
        return;
    }
    if (result != CDS_OK && result != CDS_CORRUPT) {
        next(scan);
        return;
    }
    if (scan->count < scan->room)
        scan->found[scan->count] = (struct cds_scan_found){
            .id = scan->id, .baud = scan->bus->baud, .result = result, .details = CDS_PENDING};
    scan->count++;
    if (scan->with_details && result == CDS_OK && scan->count <= scan->room)
        scan->phase = READ;
    else
        next(scan);
}

static void take_details(struct cds_scan *scan)
{
    struct cds_scan_found *found = &scan->found[scan->count - 1];

    found->details = (uint8_t)cds_request_byte(scan->request, 0, &found->model);
    cds_request_byte(scan->request, DETAILS - 1, &found->own_baud);
    if (found->details == CDS_CANCELLED)
        scan->aborted = 1;
    next(scan);
}

static void send(struct cds_scan *scan)
{
    struct cds_request *request = scan->request;
    enum cds_result result = CDS_BUSY;

    if (scan->phase == ASK) {
        request->skips_rest = true; // each ID is asked once: a stale reply has another one
        result = cds_servo_ping(scan->bus, request, scan->id);
    } else if (scan->phase == READ) {
        result = cds_servo_read(scan->bus, request, scan->id, CDS_REG_MODEL_NUMBER, DETAILS);
    }
    if (result == CDS_OK) {
        scan->phase++;               // what it is, in flight
    } else if (result != CDS_BUSY) { // the bus's observer: not that one, or not that
        if (scan->phase == READ)
            scan->found[scan->count - 1].details = (uint8_t)result;
        next(scan);
    }
}

static void give_back(struct cds_scan *scan)
{
    if (!cds_operation_tune(scan->bus, scan->own_baud))
        return;
    cds_bus_set_return_delay(scan->bus, scan->return_delay_us);
    scan->result = scan->line_busy ? CDS_LINE_BUSY : scan->aborted ? CDS_CANCELLED : CDS_OK;
}

DECLARED_NOINLINE(cds_scan_poll);

enum cds_result cds_scan_poll(struct cds_scan *scan)
{
    OPTIMIZER_BARRIER(scan);
    if (scan->phase == CHECK && scan->result == CDS_PENDING) {
        start(scan);
    } else if (scan->result == CDS_PENDING && !cds_operation_has(scan->bus)) {
        scan->request->skips_rest = false;
        scan->result = CDS_CANCELLED; // the bus is somebody else's
    }
    if (scan->result != CDS_PENDING)
        return (enum cds_result)scan->result;
    if (scan->phase == ASKED && scan->request->result != CDS_PENDING)
        asked(scan);
    if (scan->phase == READING && scan->request->result != CDS_PENDING)
        take_details(scan);
    if (scan->phase == TUNE && cds_operation_tune(scan->bus, baud_of(scan, scan->baud_index)))
        scan->phase = ASK;
    send(scan);
    if (scan->phase == GIVE_BACK)
        give_back(scan);
    return (enum cds_result)scan->result;
}
