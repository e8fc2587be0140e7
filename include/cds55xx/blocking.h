/* For programs that would rather wait: each call submits, polls the bus until its request has
 * ended, and returns how. Other requests of the bus go on meanwhile, and their on_end is called.
 *
 * Everything here waits, for at most the deadlines of what is in the queue; nothing in the library
 * calls it. Arguments and further results are those of the functions of servo.h and sync_write.h
 * named alike. Main context, not from on_end.
 */
#ifndef CDS_BLOCKING_H
#define CDS_BLOCKING_H

#include "cds55xx/servo.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Waits for a request that was submitted with the result `submitted` (so that a call can stand as
 * the argument). Its result, or `submitted` if that was not CDS_OK. Manual: nothing. */
static inline enum cds_result cds_blocking_for(struct cds_bus *bus, struct cds_request *request,
                                               enum cds_result submitted)
{
    if (submitted != CDS_OK)
        return submitted;
    while (request->result == CDS_PENDING)
        cds_bus_poll(bus);
    return (enum cds_result)request->result;
}

/* Is servo `id` there? CDS_OK: yes (2.4.5). */
static inline enum cds_result cds_blocking_ping(struct cds_bus *bus, struct cds_request *request,
                                                uint8_t id)
{
    return cds_blocking_for(bus, request, cds_servo_ping(bus, request, id));
}

/* Reads a register of one byte into *out, which is left as it was unless the result is CDS_OK;
 * CDS_REFUSED: the servo refused, request->error says why (2.4.2). */
static inline enum cds_result cds_blocking_read_byte(struct cds_bus *bus,
                                                     struct cds_request *request, uint8_t id,
                                                     uint8_t address, uint8_t *out)
{
    enum cds_result result =
        cds_blocking_for(bus, request, cds_servo_read(bus, request, id, address, 1));

    return result == CDS_OK ? cds_request_byte(request, 0, out) : result;
}

/* As cds_blocking_read_byte(), of a register of two bytes, low byte first (2.4.2, R28). */
static inline enum cds_result cds_blocking_read_word(struct cds_bus *bus,
                                                     struct cds_request *request, uint8_t id,
                                                     uint8_t address, uint16_t *out)
{
    enum cds_result result =
        cds_blocking_for(bus, request, cds_servo_read(bus, request, id, address, 2));

    return result == CDS_OK ? cds_request_word(request, 0, out) : result;
}

/* What became of a WRITE: one that the servo refused was not carried out. */
static inline enum cds_result cds_blocking_written_(const struct cds_request *request,
                                                    enum cds_result result)
{
    return result == CDS_OK && request->error & CDS_ERRORS_OF_PACKET ? CDS_REFUSED : result;
}

/* Writes a register of one byte. CDS_OK: the servo has answered, or no answer was due;
 * CDS_REFUSED: it refused, request->error says why (2.4.1). */
static inline enum cds_result cds_blocking_write_byte(struct cds_bus *bus,
                                                      struct cds_request *request, uint8_t id,
                                                      uint8_t address, uint8_t value)
{
    return cds_blocking_written_(
        request,
        cds_blocking_for(bus, request, cds_servo_write_byte(bus, request, id, address, value)));
}

/* As cds_blocking_write_byte(), to a register of two bytes, in one packet (2.4.1, R28). */
static inline enum cds_result cds_blocking_write_word(struct cds_bus *bus,
                                                      struct cds_request *request, uint8_t id,
                                                      uint8_t address, uint16_t value)
{
    return cds_blocking_written_(
        request,
        cds_blocking_for(bus, request, cds_servo_write_word(bus, request, id, address, value)));
}

#ifdef __cplusplus
}
#endif

#endif
