/* SPDX-License-Identifier: MIT */
/* The set-up of a new servo; see new_servo.h. */
#include "robot/new_servo.h"

#include <string.h>

#include "cds55xx/servo.h" // cds_servo_ping()

enum cds_result new_servo_begin(struct new_servo *servo, const struct new_servo_config *config)
{
    memset(servo, 0, sizeof *servo);
    servo->config = *config;
    servo->home_baud_reg = config->bus->baud_reg;
    servo->known = config->servos ? config->servos->count : 0;
    return CDS_OK;
}

void new_servo_abort(struct new_servo *servo)
{
    if (servo->step <= NEW_SERVO_SEARCH_THERE)
        servo->is_ending = true;
}

static void enter(struct new_servo *servo, enum new_servo_step step)
{
    servo->step = (uint8_t)step;
    servo->begun = false;
    servo->tries = 0;
}

static void finish(struct new_servo *servo, enum new_servo_outcome outcome, uint8_t result)
{
    servo->outcome = (uint8_t)outcome;
    servo->result = result;
    servo->is_ending = true;
}

static void fail(struct new_servo *servo, uint8_t result)
{
    finish(servo, result == CDS_CORRUPT ? NEW_SERVO_DAMAGED : NEW_SERVO_FAILED, result);
}

static void search_at_all_rates(struct new_servo *servo)
{
    servo->searched_any = true;
    enter(servo, NEW_SERVO_SEARCH_ANY);
}

/* The step has ended as `result`. Returns true if it was well; else the step is tried again, or
 * everything ends. A servo whose rate is a neighbour of a listed rate may answer there with damaged
 * replies: then its own rate is searched for. */
static bool is_well(struct new_servo *servo, enum cds_result result)
{
    bool is_retried = result == CDS_TIMEOUT || result == CDS_CORRUPT;

    if (result == CDS_OK)
        return true;
    servo->begun = false;
    if (is_retried && ++servo->tries < NEW_SERVO_TRIES)
        return false;
    if (is_retried && servo->step == NEW_SERVO_CHECK && !servo->searched_any) {
        servo->result = (uint8_t)result;
        search_at_all_rates(servo);
    } else {
        fail(servo, (uint8_t)result);
    }
    return false;
}

/* Sets the bus to the rate at which the servo was found. False: the bus is busy. */
static bool goes_to_servo(struct new_servo *servo)
{
    return cds_bus_set_baud(servo->config.bus, servo->baud_reg) == CDS_OK;
}

/* ---- search ---- */

static enum cds_result begin_scan(struct new_servo *servo)
{
    struct cds_scan_config config = {.bus = servo->config.bus,
                                     .request = servo->config.request,
                                     .found = servo->found,
                                     .found_capacity = NEW_SERVO_FOUND,
                                     .last_id = CDS_ID_MAX};

    if (servo->step == NEW_SERVO_SEARCH_THERE) {
        config.baud_regs = &servo->baud_reg;
        config.baud_count = 1;
    }
    return cds_scan_begin(&servo->work.scan, &config);
}

static uint16_t noise_bytes(const struct new_servo *servo)
{
    struct cds_stats stats;

    cds_bus_stats(servo->config.bus, &stats);
    return stats.noise_bytes;
}

/* Nothing has answered: a servo may answer too early, or be at another rate. */
static void search_elsewhere(struct new_servo *servo)
{
    if (!servo->mended_all && noise_bytes(servo) != servo->noise) {
        servo->mended_all = true;
        enter(servo, NEW_SERVO_MEND_ALL);
        return;
    }
    search_at_all_rates(servo);
}

/* True if the servo that was found may be one of the robot's: it has an ID and the rate of one. */
static bool is_known(const struct new_servo *servo)
{
    if (servo->baud_reg != servo->home_baud_reg)
        return false;
    for (uint8_t i = 0; i < servo->known; i++)
        if (servo->config.servos->states[i].id == servo->id)
            return true;
    return false;
}

static void search_ended(struct new_servo *servo)
{
    const struct cds_scan *scan = &servo->work.scan;

    servo->count = (uint8_t)(scan->count < NEW_SERVO_FOUND ? scan->count : NEW_SERVO_FOUND);
    servo->id = servo->found[0].id;
    if (servo->count)
        servo->baud_reg = servo->found[0].baud_reg;
    if (servo->count > 1)
        finish(servo, NEW_SERVO_NOT_ALONE, CDS_OK);
    else if (servo->count == 0 && servo->searched_any)
        finish(servo, NEW_SERVO_NONE, CDS_OK);
    else if (servo->count == 0)
        search_elsewhere(servo);
    else if (is_known(servo))
        finish(servo, NEW_SERVO_KNOWN, CDS_OK);
    else
        enter(servo, servo->found[0].result == CDS_OK ? NEW_SERVO_CHECK : NEW_SERVO_MEND_DELAY);
}

static void search(struct new_servo *servo)
{
    enum cds_result result;

    if (!servo->begun) {
        servo->noise = noise_bytes(servo);
        servo->begun = begin_scan(servo) == CDS_OK; // else the bus is in use: again
        return;
    }
    result = cds_scan_poll(&servo->work.scan);
    if (result == CDS_OK)
        search_ended(servo);
    else if (result != CDS_PENDING)
        finish(servo, NEW_SERVO_FAILED, (uint8_t)result);
}

/* The PING to all, or the READ of the rate, has ended. A servo also answers at neighbours of its
 * rate, so its own rate is read; where it cannot be read, the next rate is asked. */
static void any_answered(struct new_servo *servo)
{
    const struct cds_request *request = servo->config.request;
    bool is_good = request->result == CDS_OK;

    servo->begun = false;
    if (is_good && servo->asked_rate) {
        servo->baud_reg = request->reply[0];
        enter(servo, NEW_SERVO_SEARCH_THERE);
        return;
    }
    if (is_good) {
        servo->id = request->id;
        servo->asked_rate = true;
        return;
    }
    if (servo->asked_rate && ++servo->tries < NEW_SERVO_TRIES)
        return;
    servo->tries = 0;
    servo->asked_rate = false;
    if (servo->any_baud < CDS_BAUD_MAX)
        servo->any_baud++;
    else if (servo->result)
        fail(servo, servo->result);
    else
        finish(servo, NEW_SERVO_NONE, CDS_OK);
}

static void search_any(struct new_servo *servo)
{
    struct cds_bus *bus = servo->config.bus;
    struct cds_request *request = servo->config.request;

    if (servo->begun) {
        if (request->result != CDS_PENDING)
            any_answered(servo);
        return;
    }
    if (cds_bus_set_baud(bus, servo->any_baud) != CDS_OK)
        return;
    servo->begun =
        (servo->asked_rate ? cds_servo_read(bus, request, servo->id, CDS_REG_BAUD_RATE, 1)
                           : cds_servo_ping(bus, request, CDS_BROADCAST_ID)) == CDS_OK;
}

/* ---- set-up ---- */

/* A servo that answers before this board listens hears all the same: the WRITE has no good reply,
 * and the next step shows whether the servo can be understood then. */
static void mend_delay(struct new_servo *servo)
{
    struct cds_request *request = servo->config.request;

    if (servo->begun) {
        if (request->result != CDS_PENDING)
            enter(servo, NEW_SERVO_CHECK);
        return;
    }
    if (goes_to_servo(servo))
        servo->begun =
            cds_servo_write_byte(servo->config.bus, request, servo->id, CDS_REG_RETURN_DELAY,
                                 servo->config.return_delay) == CDS_OK;
}

/* Writes the return delay by broadcast, at one listed rate after the other. */
static void mend_all(struct new_servo *servo)
{
    struct cds_bus *bus = servo->config.bus;
    struct cds_request *request = servo->config.request;

    if (servo->begun && request->result == CDS_PENDING)
        return;
    if (servo->begun) {
        servo->begun = false;
        if (++servo->listed == CDS_SCAN_LISTED_BAUDS)
            enter(servo, NEW_SERVO_SEARCH_LISTED);
        return;
    }
    if (cds_bus_set_baud(bus, cds_scan_listed_baud_regs[servo->listed]) == CDS_OK)
        servo->begun = cds_servo_write_byte(bus, request, CDS_BROADCAST_ID, CDS_REG_RETURN_DELAY,
                                            servo->config.return_delay) == CDS_OK;
}

/* The servo can be understood. A servo also answers at neighbours of its rate, so its register says
 * which rate it has. */
static void checked(struct new_servo *servo)
{
    servo->baud_reg = servo->first_baud_reg = servo->config.request->reply[CDS_REG_BAUD_RATE];
    if (is_known(servo))
        finish(servo, NEW_SERVO_KNOWN, CDS_OK);
    else
        enter(servo, NEW_SERVO_SET_DELAY);
}

static void check(struct new_servo *servo)
{
    struct cds_request *request = servo->config.request;

    if (!servo->begun) {
        servo->begun = goes_to_servo(servo) && cds_servo_read(servo->config.bus, request, servo->id,
                                                              0, CDS_TABLE_SIZE) == CDS_OK;
        return;
    }
    if (request->result != CDS_PENDING && is_well(servo, (enum cds_result)request->result))
        checked(servo);
}

static void set_delay(struct new_servo *servo)
{
    struct cds_setup_config config = {.bus = servo->config.bus,
                                      .request = servo->config.request,
                                      .id = servo->id,
                                      .setting = CDS_SETUP_REGISTERS,
                                      .address = CDS_REG_RETURN_DELAY,
                                      .length = 1,
                                      .data = &servo->config.return_delay};
    enum cds_result result;

    if (!servo->begun) {
        servo->begun =
            goes_to_servo(servo) && cds_setup_begin(&servo->work.setup, &config) == CDS_OK;
        return;
    }
    result = cds_setup_poll(&servo->work.setup);
    if (result != CDS_PENDING && is_well(servo, result))
        enter(servo, NEW_SERVO_SET_ID);
}

static enum cds_result begin_identity(struct new_servo *servo)
{
    struct cds_identity_config config = {.bus = servo->config.bus,
                                         .request = servo->config.request,
                                         .id = servo->id,
                                         .new_id = servo->config.id,
                                         .new_baud_reg = servo->home_baud_reg};

    config.change =
        servo->step == NEW_SERVO_SET_ID ? (uint8_t)CDS_IDENTITY_ID : (uint8_t)CDS_IDENTITY_BAUD;
    return cds_identity_begin(&servo->work.identity, &config);
}

/* True if the change was written and the servo answers at neither place, as after a loss of power.
 * Looks again then; after the last try everything ends. */
static bool is_lost(struct new_servo *servo, enum cds_result result)
{
    if (servo->work.identity.state != CDS_IDENTITY_LOST || !servo->work.identity.is_written)
        return false;
    if (++servo->tries >= NEW_SERVO_TRIES ||
        cds_identity_look_again(&servo->work.identity) != CDS_OK)
        finish(servo, NEW_SERVO_LOST, (uint8_t)result);
    return true;
}

static void set_identity(struct new_servo *servo)
{
    enum cds_result result;

    if (!servo->begun) {
        servo->begun = goes_to_servo(servo) && begin_identity(servo) == CDS_OK;
        return;
    }
    result = cds_identity_poll(&servo->work.identity);
    if (result == CDS_PENDING || is_lost(servo, result) || !is_well(servo, result))
        return;
    servo->id = servo->config.id;
    if (servo->step == NEW_SERVO_SET_RATE)
        servo->baud_reg = servo->home_baud_reg;
    enter(servo, servo->step == NEW_SERVO_SET_ID ? NEW_SERVO_SET_RATE : NEW_SERVO_DONE);
    if (servo->step == NEW_SERVO_DONE)
        finish(servo, NEW_SERVO_OK, CDS_OK);
}

/* Ends the search under way. True: it has ended. */
static bool end_search(struct new_servo *servo)
{
    if (!servo->begun)
        return true;
    if (servo->step == NEW_SERVO_SEARCH_ANY || servo->step == NEW_SERVO_MEND_ALL)
        return servo->config.request->result != CDS_PENDING;
    cds_scan_abort(&servo->work.scan);
    return cds_scan_poll(&servo->work.scan) != CDS_PENDING;
}

/* Gives the bus its rate back. */
static enum cds_result end(struct new_servo *servo)
{
    if (servo->outcome == NEW_SERVO_OK && servo->step != NEW_SERVO_DONE) {
        if (!end_search(servo))
            return CDS_PENDING;
        servo->outcome = NEW_SERVO_ENDED;
    }
    return cds_bus_set_baud(servo->config.bus, servo->home_baud_reg) == CDS_OK ? CDS_OK
                                                                               : CDS_PENDING;
}

enum cds_result new_servo_poll(struct new_servo *servo)
{
    if (servo->is_ending)
        return end(servo);
    switch (servo->step) {
    case NEW_SERVO_MEND_ALL: mend_all(servo); break;
    case NEW_SERVO_SEARCH_ANY: search_any(servo); break;
    case NEW_SERVO_MEND_DELAY: mend_delay(servo); break;
    case NEW_SERVO_CHECK: check(servo); break;
    case NEW_SERVO_SET_DELAY: set_delay(servo); break;
    case NEW_SERVO_SET_ID:
    case NEW_SERVO_SET_RATE: set_identity(servo); break;
    default: search(servo); break;
    }
    return CDS_PENDING;
}
