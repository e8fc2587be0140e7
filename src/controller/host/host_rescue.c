/* SPDX-License-Identifier: MIT */
/* Two seconds at the board's own rate; see host_rescue.h. */
#include "host/host_rescue.h"

#include "cds55xx/port.h"   // cds_port_now_us()
#include "ring_input.h"     // ring_peek(), ring_drop()
#include "robot/failsafe.h" // FAILSAFE_RESET_...
#include "compiler.h"       // OPTIMIZER_BARRIER(), NOINLINE

#define CTRL_X  0x18
#define WINDOW  31 // x 65.536 ms: 1.97 s to 2.03 s
#define SILENCE 79 // x 256 us: 20.0 ms to 20.2 ms

/* In units of 65.536 ms. */
static uint8_t window_time(uint32_t now_us)
{
    return (uint8_t)(now_us >> 16);
}

/* In units of 256 us. */
static uint8_t silence_time(uint32_t now_us)
{
    return (uint8_t)(now_us >> 8);
}

bool host_rescue_begin(struct host_rescue *rescue, uint8_t reset_cause)
{
    rescue->begun = window_time(cds_port_now_us());
    if (reset_cause & (FAILSAFE_RESET_POWER | FAILSAFE_RESET_EXTERNAL) ||
        !(reset_cause & (FAILSAFE_RESET_BROWN_OUT | FAILSAFE_RESET_WATCHDOG)))
        rescue->state = HOST_RESCUE_OPEN;
    return rescue->state;
}

void host_rescue_damage(struct host_rescue *rescue)
{
    rescue->enters = 0;
    rescue->after_cr = false;
    rescue->ctrl_x = false;
    rescue->other = true;
}

static void take(struct host_rescue *rescue, uint8_t byte)
{
    bool after_cr = rescue->after_cr;

    rescue->after_cr = byte == '\r';
    if (byte == '\r' || (byte == '\n' && !after_cr)) {
        rescue->enters++;
    } else if (byte == CTRL_X) {
        rescue->enters = 0;
        rescue->ctrl_x = !rescue->other;
    } else if (byte != '\n') {
        host_rescue_damage(rescue);
    }
}

bool host_rescue_poll(struct host_rescue *rescue, struct cds_ring *input)
{
    uint32_t now_us = cds_port_now_us();
    bool stop;

    OPTIMIZER_BARRIER(rescue);
    if (cds_ring_count(input)) {
        take(rescue, ring_peek(input, 0));
        ring_drop(input, 1);
        rescue->heard = silence_time(now_us);
    }
    if ((uint8_t)(window_time(now_us) - rescue->begun) >= WINDOW)
        rescue->state = HOST_RESCUE_EXPIRED;
    if (rescue->enters == HOST_RESCUE_ENTERS)
        rescue->state = HOST_RESCUE_SHUT;
    if (rescue->state == HOST_RESCUE_OPEN &&
        (uint8_t)(silence_time(now_us) - rescue->heard) < SILENCE)
        return false;
    stop = rescue->ctrl_x;
    rescue->ctrl_x = false;
    return stop;
}
