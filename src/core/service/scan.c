/* SPDX-License-Identifier: MIT */
/* PING of IDs at baud rates; see scan.h. */
#include "cds55xx/scan.h"

#include <stddef.h>

#include "bus/steps_internal.h" // cds_steps_poll()
#include "cds55xx/servo.h"      // cds_servo_ping(), cds_servo_read()
#include "compiler.h"           // NOINLINE

const uint8_t cds_scan_listed_baud_regs[CDS_SCAN_LISTED_BAUDS] = {1, 3, 7, 16, 34, 103};

NOINLINE static uint8_t baud_reg_of(const struct cds_scan_config *config, uint8_t index)
{
    return config->tries_every_rate ? index : config->baud_regs[index];
}

static enum cds_result check(const struct cds_scan_config *config)
{
    if (config->first_id > config->last_id || config->last_id > CDS_ID_MAX ||
        config->baud_count == 0)
        return CDS_BAD_ARGUMENT;
    for (uint8_t i = 0; i < config->baud_count; i++)
        if (baud_reg_of(config, i) > CDS_BAUD_MAX)
            return CDS_BAD_ARGUMENT;
    return cds_steps_check_exclusive(config->bus, config->request, CDS_SCAN_PACKET_SIZE,
                                     config->reads_details ? CDS_SCAN_REPLY_SIZE : 0);
}

enum cds_result cds_scan_begin(struct cds_scan *scan, const struct cds_scan_config *config)
{
    struct cds_scan_config own = *config;
    enum cds_result result;

    if (own.tries_every_rate) {
        own.baud_count = CDS_BAUD_MAX + 1;
    } else if (!own.baud_regs && own.baud_count == 0) {
        own.baud_regs = cds_scan_listed_baud_regs;
        own.baud_count = CDS_SCAN_LISTED_BAUDS;
    } else if (!own.baud_regs) {
        return CDS_BAD_ARGUMENT;
    }
    result = check(&own);
    if (result != CDS_OK)
        return result;
    *scan = (struct cds_scan){
        .config = own,
        .id = own.first_id,
        .total = (uint16_t)((uint16_t)(own.last_id - own.first_id + 1) * own.baud_count),
    };
    cds_steps_begin_exclusive(&scan->steps, own.bus, own.request);
    return CDS_OK;
}

void cds_scan_abort(struct cds_scan *scan)
{
    cds_steps_abort(&scan->steps);
}

static void next(struct cds_scan *scan)
{
    scan->is_reading = false;
    scan->asked++;
    if (scan->id < scan->config.last_id) {
        scan->id++;
        return;
    }
    scan->id = scan->config.first_id;
    scan->baud_index++;
    if (scan->baud_index == scan->config.baud_count)
        cds_steps_end(&scan->steps, CDS_OK);
}

static void take_details(struct cds_scan *scan, enum cds_result result)
{
    struct cds_scan_found *found = &scan->config.found[scan->count - 1];

    if (result == CDS_OK) {
        cds_request_byte(scan->config.request, 0, &found->model);
        cds_request_byte(scan->config.request, CDS_SCAN_REPLY_SIZE - 1, &found->own_baud_reg);
    }
    found->details = (uint8_t)result;
    next(scan);
}

/* A servo has answered the PING, with `result` CDS_OK or CDS_CORRUPT. */
static void add(struct cds_scan *scan, enum cds_result result)
{
    bool is_kept = scan->count < scan->config.found_capacity;

    if (is_kept)
        scan->config.found[scan->count] = (struct cds_scan_found){
            .id = scan->id,
            .baud_reg = scan->config.bus->baud_reg,
            .result = (uint8_t)result,
            .details = CDS_PENDING,
        };
    scan->count++;
    scan->is_reading = is_kept && scan->config.reads_details && result == CDS_OK;
    if (!scan->is_reading)
        next(scan);
}

static void ended(void *operation, enum cds_result result)
{
    struct cds_scan *scan = (struct cds_scan *)operation;

    if (scan->is_reading)
        take_details(scan, result);
    else if (result == CDS_LINE_BUSY)
        cds_steps_end(&scan->steps, CDS_LINE_BUSY);     // no other servo can be asked either
    else if (result == CDS_OK || result == CDS_REFUSED) // a servo has replied
        add(scan, CDS_OK);
    else if (result == CDS_CORRUPT)
        add(scan, CDS_CORRUPT);
    else if (result != CDS_CANCELLED)
        next(scan);
}

static enum cds_result send(void *operation)
{
    struct cds_scan *scan = (struct cds_scan *)operation;
    const struct cds_scan_config *config = &scan->config;

    if (!cds_steps_set_baud(&scan->steps, baud_reg_of(config, scan->baud_index)))
        return CDS_BUSY;
    config->request->ignores_stale = !scan->is_reading; // a stale reply comes from another ID
    if (scan->is_reading)
        return cds_servo_read(config->bus, config->request, scan->id, CDS_REG_MODEL_NUMBER,
                              CDS_SCAN_REPLY_SIZE);
    return cds_servo_ping(config->bus, config->request, scan->id);
}

enum cds_result cds_scan_poll(struct cds_scan *scan)
{
    return cds_steps_poll(&scan->steps, scan, send, ended);
}
