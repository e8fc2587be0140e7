/* The rescue of a host link whose saved rate nobody can use: for 2 s after a reset the link has the
 * board's own rate, and three Enters in a row keep that rate.
 *
 * A program that talks at the saved rate in this time gives damaged bytes and any others; these
 * start the count of Enters anew. Ctrl-X stops the robot as soon as 20 ms of silence have shown
 * that a key was pressed, but not if anything else than Enter and Ctrl-X came since the reset: a
 * byte of such a program may look like Ctrl-X.
 *
 * Main context.
 */
#ifndef CONTROLLER_HOST_RESCUE_H
#define CONTROLLER_HOST_RESCUE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/ring.h" // struct cds_ring

#define HOST_RESCUE_ENTERS 3

/* While the window is not shut, the link has the board's own rate, and input is the rescue's. */
enum host_rescue_state {
    HOST_RESCUE_SHUT,
    HOST_RESCUE_OPEN,
    HOST_RESCUE_EXPIRED, // the time is over: who changes the rate of the link then shuts the window
} __attribute__((packed));

/* Zeroed, the window is shut. */
struct host_rescue {
    uint8_t begun;  // when the window opened, in units of 65.5 ms
    uint8_t heard;  // when the last byte was taken, in units of 256 us
    uint8_t enters; // in a row, the last bytes that came; HOST_RESCUE_ENTERS shut the window
    bool after_cr;  // a LF now belongs to the same Enter
    bool other;     // a damaged byte, or another one than CR, LF and Ctrl-X, has come
    bool ctrl_x;    // Ctrl-X has come, and it is not decided yet
    uint8_t state;  // enum host_rescue_state
};

/* Opens the window, unless the last reset was by watchdog or brown-out alone: the controller must
 * then be back at once. `reset_cause`: enum failsafe_reset bits, 0 if the cause is not known.
 * Returns true if it has opened the window. */
bool host_rescue_begin(struct host_rescue *rescue, uint8_t reset_cause);

/* Takes a byte if there is one, and tells when the time is over: to be called often, at least every
 * 40 ms, until the window is shut. Returns true once for each press of Ctrl-X. */
bool host_rescue_poll(struct host_rescue *rescue, struct cds_ring *input);

/* A byte with a framing error came, or bytes were lost, behind all that was taken. */
void host_rescue_damage(struct host_rescue *rescue);

#endif
