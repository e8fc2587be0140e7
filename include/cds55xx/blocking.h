/* SPDX-License-Identifier: MIT */
/* For programs that would rather wait: each call begins an instruction or an operation, polls the
 * bus until it has ended, and returns its result. Other requests of the bus go on meanwhile, and
 * their on_end is called.
 *
 *     uint16_t position;
 *     if (cds_blocking_read_word(&bus, &request, 1, CDS_REG_PRESENT_POSITION, &position) == CDS_OK)
 *         ...
 *
 * Arguments and further results are those of the function that each call names. A servo that
 * refuses is CDS_REFUSED; request->error says why. Nothing in the library calls these functions.
 * Main context, not from on_end.
 */
#ifndef CDS_BLOCKING_H
#define CDS_BLOCKING_H

#include "cds55xx/diagnose.h"
#include "cds55xx/feedback.h"
#include "cds55xx/group_read.h"
#include "cds55xx/identity.h"
#include "cds55xx/registered_move.h"
#include "cds55xx/scan.h"
#include "cds55xx/servo.h"
#include "cds55xx/setup.h"
#include "cds55xx/sync_write.h"
#include "cds55xx/torque_off.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- one transaction ---- */

/* Polls `bus` until `request` has ended; `submitted` is what its submit returned. Returns
 * `submitted` unless that is CDS_OK, else CDS_REFUSED or request->result. */
static inline enum cds_result cds_blocking_for(struct cds_bus *bus, struct cds_request *request,
                                               enum cds_result submitted)
{
    if (submitted != CDS_OK)
        return submitted;
    while (request->result == CDS_PENDING)
        cds_bus_poll(bus);
    if (request->result == CDS_OK && request->error & CDS_ERRORS_OF_PACKET)
        return CDS_REFUSED;
    return (enum cds_result)request->result;
}

/* cds_servo_ping(): CDS_OK if the servo answered well. */
static inline enum cds_result cds_blocking_ping(struct cds_bus *bus, struct cds_request *request,
                                                uint8_t id)
{
    return cds_blocking_for(bus, request, cds_servo_ping(bus, request, id));
}

/* cds_servo_read(): the bytes are in request->reply. */
static inline enum cds_result cds_blocking_read(struct cds_bus *bus, struct cds_request *request,
                                                uint8_t id, uint8_t address, uint8_t length)
{
    return cds_blocking_for(bus, request, cds_servo_read(bus, request, id, address, length));
}

/* cds_servo_read() and cds_request_byte(): reads a register of one byte into *out, which stays as
 * it was unless the result is CDS_OK. */
static inline enum cds_result cds_blocking_read_byte(struct cds_bus *bus,
                                                     struct cds_request *request, uint8_t id,
                                                     uint8_t address, uint8_t *out)
{
    enum cds_result result = cds_blocking_read(bus, request, id, address, 1);

    return result == CDS_OK ? cds_request_byte(request, 0, out) : result;
}

/* cds_servo_read() and cds_request_word(): reads a register of two bytes into *out, which stays as
 * it was unless the result is CDS_OK. */
static inline enum cds_result cds_blocking_read_word(struct cds_bus *bus,
                                                     struct cds_request *request, uint8_t id,
                                                     uint8_t address, uint16_t *out)
{
    enum cds_result result = cds_blocking_read(bus, request, id, address, 2);

    return result == CDS_OK ? cds_request_word(request, 0, out) : result;
}

/* cds_feedback_read() and cds_feedback_take(). */
static inline enum cds_result cds_blocking_feedback(struct cds_bus *bus,
                                                    struct cds_request *request, uint8_t id,
                                                    struct cds_feedback *feedback)
{
    enum cds_result submitted = cds_feedback_read(bus, request, id);

    cds_blocking_for(bus, request, submitted);
    return submitted == CDS_OK ? cds_feedback_take(feedback, request, cds_port_now_us())
                               : submitted;
}

/* cds_servo_write(): CDS_OK if the servo has acknowledged the WRITE, or no reply was due. */
static inline enum cds_result cds_blocking_write(struct cds_bus *bus, struct cds_request *request,
                                                 uint8_t id, uint8_t address, const uint8_t *data,
                                                 uint8_t length)
{
    return cds_blocking_for(bus, request, cds_servo_write(bus, request, id, address, data, length));
}

/* cds_servo_write_byte() */
static inline enum cds_result cds_blocking_write_byte(struct cds_bus *bus,
                                                      struct cds_request *request, uint8_t id,
                                                      uint8_t address, uint8_t value)
{
    return cds_blocking_for(bus, request, cds_servo_write_byte(bus, request, id, address, value));
}

/* cds_servo_write_word() */
static inline enum cds_result cds_blocking_write_word(struct cds_bus *bus,
                                                      struct cds_request *request, uint8_t id,
                                                      uint8_t address, uint16_t value)
{
    return cds_blocking_for(bus, request, cds_servo_write_word(bus, request, id, address, value));
}

/* cds_servo_reg_write() */
static inline enum cds_result cds_blocking_reg_write(struct cds_bus *bus,
                                                     struct cds_request *request, uint8_t id,
                                                     uint8_t address, const uint8_t *data,
                                                     uint8_t length)
{
    return cds_blocking_for(bus, request,
                            cds_servo_reg_write(bus, request, id, address, data, length));
}

/* cds_servo_action() */
static inline enum cds_result cds_blocking_action(struct cds_bus *bus, struct cds_request *request,
                                                  uint8_t id)
{
    return cds_blocking_for(bus, request, cds_servo_action(bus, request, id));
}

/* cds_servo_reset() */
static inline enum cds_result cds_blocking_reset(struct cds_bus *bus, struct cds_request *request,
                                                 uint8_t id)
{
    return cds_blocking_for(bus, request, cds_servo_reset(bus, request, id));
}

/* cds_sync_write_send(), of a packet that cds_sync_write_begin() began. */
static inline enum cds_result cds_blocking_sync_write(struct cds_bus *bus,
                                                      struct cds_request *request)
{
    return cds_blocking_for(bus, request, cds_sync_write_send(bus, request));
}

/* ---- operations: begin with `config`, poll to the end ---- */

/* cds_sync_write_many_begin(), cds_sync_write_many_poll(): the data go to their servos, in as many
 * packets as that takes. */
static inline enum cds_result
cds_blocking_sync_write_many(struct cds_sync_write_many *write,
                             const struct cds_sync_write_many_config *config)
{
    enum cds_result result = cds_sync_write_many_begin(write, config);

    if (result != CDS_OK)
        return result;
    while ((result = cds_sync_write_many_poll(write)) == CDS_PENDING)
        cds_bus_poll(config->bus);
    return result;
}

/* cds_group_read_begin(), cds_group_read_poll(): the registers of each servo are read. */
static inline enum cds_result cds_blocking_group_read(struct cds_group_read *read,
                                                      const struct cds_group_read_config *config)
{
    enum cds_result result = cds_group_read_begin(read, config);

    if (result != CDS_OK)
        return result;
    while ((result = cds_group_read_poll(read)) == CDS_PENDING)
        cds_bus_poll(config->bus);
    return result;
}

/* cds_registered_move_begin(), cds_registered_move_poll(): the servos of config->goals begin to
 * move together. */
static inline enum cds_result
cds_blocking_registered_move(struct cds_registered_move *move,
                             const struct cds_registered_move_config *config)
{
    enum cds_result result = cds_registered_move_begin(move, config);

    if (result != CDS_OK)
        return result;
    while ((result = cds_registered_move_poll(move)) == CDS_PENDING)
        cds_bus_poll(config->bus);
    return result;
}

/* cds_torque_off_begin(), cds_torque_off_poll(): torque is switched off for all servos. */
static inline enum cds_result cds_blocking_torque_off(struct cds_torque_off *off,
                                                      struct cds_servos *servos)
{
    enum cds_result result = cds_torque_off_begin(off, servos);

    if (result != CDS_OK)
        return result;
    while ((result = cds_torque_off_poll(off)) == CDS_PENDING)
        cds_bus_poll(servos->bus);
    return result;
}

/* cds_scan_begin(), cds_scan_poll(): the servos that answer are in config->found. */
static inline enum cds_result cds_blocking_scan(struct cds_scan *scan,
                                                const struct cds_scan_config *config)
{
    enum cds_result result = cds_scan_begin(scan, config);

    if (result != CDS_OK)
        return result;
    while ((result = cds_scan_poll(scan)) == CDS_PENDING)
        cds_bus_poll(config->bus);
    return result;
}

/* cds_identity_begin(), cds_identity_poll(): a servo gets another ID or baud rate, or is reset. */
static inline enum cds_result cds_blocking_identity(struct cds_identity *identity,
                                                    const struct cds_identity_config *config)
{
    enum cds_result result = cds_identity_begin(identity, config);

    if (result != CDS_OK)
        return result;
    while ((result = cds_identity_poll(identity)) == CDS_PENDING)
        cds_bus_poll(config->bus);
    return result;
}

/* cds_setup_begin(), cds_setup_poll(): a servo gets a setting, which is read back. */
static inline enum cds_result cds_blocking_setup(struct cds_setup *setup,
                                                 const struct cds_setup_config *config)
{
    enum cds_result result = cds_setup_begin(setup, config);

    if (result != CDS_OK)
        return result;
    while ((result = cds_setup_poll(setup)) == CDS_PENDING)
        cds_bus_poll(config->bus);
    return result;
}

/* cds_diagnose_begin(), cds_diagnose_poll(): the finding is in diagnose->finding. */
static inline enum cds_result cds_blocking_diagnose(struct cds_diagnose *diagnose,
                                                    const struct cds_diagnose_config *config)
{
    enum cds_result result = cds_diagnose_begin(diagnose, config);

    if (result != CDS_OK)
        return result;
    while ((result = cds_diagnose_poll(diagnose)) == CDS_PENDING)
        cds_bus_poll(config->bus);
    return result;
}

#ifdef __cplusplus
}
#endif

#endif
