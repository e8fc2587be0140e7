/* SPDX-License-Identifier: MIT */
/* Did it work? One answer for every call of the library, apart from what the servo itself reports
 * (the CDS_ERROR_* bits of packet.h). A request is CDS_OK as soon as its servo has answered, also
 * if that refuses; calls that wait and operations of several steps then end as CDS_REFUSED.
 *
 * This table is the only list: the enum below, the console's texts and docs/errors.md come from it.
 */
#ifndef CDS_RESULT_H
#define CDS_RESULT_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* X(name, number, text, remedy). The order matters: the packet of a request that ended as
 * CDS_CORRUPT or lower was sent, from CDS_LINE_BUSY on it was not, and from CDS_NO_REPLY_DUE on the
 * permit refused it. */
#define CDS_RESULTS(X)                                                                             \
    X(CDS_OK, 0, "ok", "nothing to do")                                                            \
    X(CDS_PENDING, 1, "transaction in progress", "wait until it has ended")                        \
    X(CDS_TIMEOUT, 2, "no reply by the deadline",                                                  \
      "check power, wiring, ID and baud rate of the servo")                                        \
    X(CDS_CORRUPT, 3, "reply damaged",                                                             \
      "look for two servos with one ID, another baud rate, or noise on the line")                  \
    X(CDS_BUSY, 4, "request busy", "submit it again when its transaction has ended")               \
    X(CDS_BAD_ARGUMENT, 5, "argument out of range", "'help COMMAND' or the header has the range")  \
    X(CDS_NO_ROOM, 6, "packet too long",                                                           \
      "send fewer bytes or servos at once, or enlarge the buffer")                                 \
    X(CDS_REFUSED, 7, "refused by a servo",                                                        \
      "the servo may be locked until power-off, or the value out of its range: read LOCK")         \
    X(CDS_CANCELLED, 8, "request taken back", "submit it again if it is still wanted")             \
    X(CDS_LINE_BUSY, 9, "line not quiet, nothing was sent",                                        \
      "look for a servo that babbles, a short circuit, or a second controller")                    \
    X(CDS_NO_REPLY_DUE, 10, "the servo is set not to answer this",                                 \
      "'set ID STATUS_RETURN_LEVEL 2' lets it answer")                                             \
    X(CDS_LIMIT, 11, "not within the servo's limits",                                              \
      "see 'servos' and docs/safety.md; 'id' sets an ID")                                          \
    X(CDS_INHIBITED, 12, "the servo may not be driven",                                            \
      "'servos' tells why: mend power, load, plug or heat, then 'release'")                        \
    X(CDS_TOO_EARLY, 13, "replies would come too early for this board",                            \
      "raise the servo's RETURN_DELAY; 'status' shows the lowest value")                           \
    X(CDS_RESERVED, 14, "a motion moves the servo", "wait until the motion has ended, or end it")

/* CDS_OK, CDS_PENDING and so on, as listed above. Every enum here is packed into one byte: else
 * avr-gcc takes two. */
enum cds_result {
#define CDS_RESULT_ENUM_(name, number, text, remedy) name = number,
    CDS_RESULTS(CDS_RESULT_ENUM_)
#undef CDS_RESULT_ENUM_
} __attribute__((packed));

/* Copies the text of `result`, an enum cds_result, to `text`: at most capacity - 1 characters and a
 * 0, `capacity` 1 or more. CDS_RESULT_TEXT_SIZE holds every text. On an AVR the texts stand in
 * flash. Returns the length of what was copied; 0: there is no such result. Any context. */
#define CDS_RESULT_TEXT_SIZE 64
uint8_t cds_result_text(uint8_t result, char *text, uint8_t capacity);

#ifdef __cplusplus
}
#endif

#endif
