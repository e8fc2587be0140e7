/* The firmware, its own main.c, with a cycle beside it: 18 servos at 250 Hz, all goals and as much
 * feedback as there is time for. For a host that floods the link meanwhile. */
#include <cds55xx/cycle.h>

#include "../../src/avr/idle.h"

static void cycle_turn(void);
#define avr_idle(busy, context) ((void)(busy), cycle_turn())

#include "../../src/controller/main.c"

#define SERVOS 18

static struct cds_cycle cycle;
static uint8_t ids[SERVOS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS)];
static struct cds_feedback feedback[SERVOS];

static void begin(void)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        ids[i] = (uint8_t)(i + 1);
    cds_cycle_begin(&cycle, &controller.bus, ids, SERVOS, packets, feedback, CDS_CYCLE_PERIOD_US);
    for (uint8_t i = 0; i < SERVOS; i++)
        cds_cycle_goal(&cycle, i, 512, 0);
    cds_cycle_commit(&cycle);
}

/* Instead of sleeping. */
static void cycle_turn(void)
{
    if (cycle.count == 0)
        begin();
    cds_cycle_poll(&cycle);
}
