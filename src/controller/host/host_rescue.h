/* SPDX-License-Identifier: MIT */
/* Rescues a host link whose saved rate the PC cannot use. For 2 s after a reset the link has the
 * board's own rate, and three Enters in a row keep that rate.
 *
 * A program that talks at the saved rate meanwhile is heard as damaged or random bytes. Each of
 * these starts the count of Enters again. Ctrl-X stops the robot after 20 ms of silence, which show
 * that a key was pressed. It does not stop the robot if any byte but Enter and Ctrl-X has come
 * since the reset: a byte of such a program may look like Ctrl-X.
 *
 * Main context.
 */
#ifndef CONTROLLER_HOST_RESCUE_H
#define CONTROLLER_HOST_RESCUE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/ring.h" // struct cds_ring

#define HOST_RESCUE_ENTERS 3

/* Until the window is shut, the link has the board's own rate, and only the rescue takes its input.
 */
enum host_rescue_state {
    HOST_RESCUE_SHUT,
    HOST_RESCUE_OPEN,
    HOST_RESCUE_EXPIRED, // the time is over: main.c changes the rate and shuts the window
} __attribute__((packed));

/* Zero it: the window is shut. */
struct host_rescue {
    uint8_t begun;  // when the window opened, in units of 65.5 ms
    uint8_t heard;  // when the last byte was taken, in units of 256 us
    uint8_t enters; // in a row until now; HOST_RESCUE_ENTERS shut the window
    bool after_cr;  // the last byte was CR: LF now belongs to the same Enter
    bool other;     // a damaged byte, or one that is not CR, LF or Ctrl-X, has come
    bool ctrl_x;    // Ctrl-X has come and has not stopped the robot yet
    uint8_t state;  // enum host_rescue_state
};

/* Opens the window unless the last reset was by watchdog or brown-out alone: after these the
 * controller must work at once. `reset_cause`: enum failsafe_reset bits, 0 if the cause is not
 * known. Returns true if it has opened the window. */
bool host_rescue_begin(struct host_rescue *rescue, uint8_t reset_cause);

/* Takes a byte if there is one, and ends the window when its time is over. Call it at least every
 * 40 ms until the window is shut. Returns true once for each press of Ctrl-X. */
bool host_rescue_poll(struct host_rescue *rescue, struct cds_ring *input);

/* Bytes were damaged or lost after the last byte that was taken. */
void host_rescue_damage(struct host_rescue *rescue);

#endif
