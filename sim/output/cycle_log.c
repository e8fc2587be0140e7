#include "output/cycle_log.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "output/files.h"

/* --- interrupts off ------------------------------------------------------------------------------
 */

/* Behind the instruction that turned them on or off; an entry has told already. */
static void interrupts_changed(void *context, bool on)
{
    struct times *times = context;
    uint64_t now = times->cpu->avr->cycle;
    if (on && times->off && now - times->off_since > times->longest_off) {
        times->longest_off = now - times->off_since;
        times->longest_off_at = times->off_since;
    }
    if (!on && !times->off) {
        times->off_since = now;
    }
    times->off = !on;
}

/* --- handlers ------------------------------------------------------------------------------------
 */

static void entered(struct times *times, uint64_t now)
{
    const struct cpu *cpu = times->cpu;
    if (times->depth < TIMES_DEPTH) {
        times->running[times->depth++] =
            (struct times_running){.vector = cpu->vectors[cpu->depth - 1], .entered = now};
    }
    times->off = true;
    times->off_since = now;
}

/* `now` is within RETI, whose cycles are to come. */
static void left(struct times *times, uint64_t now)
{
    const struct times_running *running = &times->running[--times->depth];
    struct times_handler *handler = &times->handler[running->vector % TIMES_VECTORS];
    uint64_t took = now + 2u + times->cpu->avr->address_size - running->entered;
    uint64_t own = took - running->nested;
    handler->times++;
    handler->cycles += own;
    handler->longest = own > handler->longest ? own : handler->longest;
    if (times->depth) {
        times->running[times->depth - 1].nested += took;
    }
}

void times_handler(struct times *times, uint64_t now)
{
    if (!times->file) {
        return;
    }
    if (times->cpu->depth > times->depth) {
        entered(times, now);
    } else if (times->cpu->depth + 1 == times->depth) {
        left(times, now);
    } else { // a reset
        times->depth = 0;
        times->off = false;
    }
}

/* --- pins ----------------------------------------------------------------------------------------
 */

static uint8_t port_level(const struct pin *pin)
{
    const uint8_t *data = pin->port->io.avr->data;
    return data[pin->port->r_ddr] & data[pin->port->r_port];
}

static void pins_changed(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq, (void)value;
    struct times *times = param;
    uint8_t level = port_level(&times->stamp);
    unsigned changed = level ^ times->level;
    for (unsigned bit = 0; bit < 8; bit++) {
        if (changed >> bit & 1) {
            fprintf(times->file, "pin %" PRIu64 " %u %d %" PRIu64 "\n", times->cpu->avr->cycle, bit,
                    level >> bit & 1, times->cpu->in_handlers);
        }
    }
    times->level = level;
}

bool times_stamp(struct times *times, const char *port)
{
    if (!times->file) {
        fputs("--stamp is for --times\n", stderr);
        return false;
    }
    if (strlen(port) != 1 || !pin_find(&times->stamp, times->cpu->avr, port[0], 0)) {
        fprintf(stderr, "--stamp %s: the chip has no such port; wanted: its letter, as in B\n",
                port);
        return false;
    }
    pin_watch(&times->stamp, pins_changed, times);
    return true;
}

/* --- instructions --------------------------------------------------------------------------------
 */

static void stepped(void *context, uint64_t now, uint32_t pc)
{
    const struct times *times = context;
    if (now >= times->steps_from && now < times->steps_to) {
        fprintf(times->file, "step %" PRIu64 " %" PRIu32 "\n", now, pc);
    }
}

/* Digits only, up to UINT64_MAX. Returns what stands behind them, or 0. */
static const char *parse_cycle(const char *text, uint64_t *cycle)
{
    char *end = 0;
    errno = 0;
    if (!isdigit((unsigned char)*text)) {
        return 0;
    }
    *cycle = strtoull(text, &end, 10);
    return errno ? 0 : end;
}

static bool parse_span(struct times *times, const char *span)
{
    const char *behind = parse_cycle(span, &times->steps_from);
    behind = behind && *behind == '-' ? parse_cycle(behind + 1, &times->steps_to) : 0;
    return behind && !*behind && times->steps_from < times->steps_to;
}

bool times_steps(struct times *times, const char *span)
{
    if (!times->file) {
        fputs("--steps is for --times\n", stderr);
        return false;
    }
    if (!parse_span(times, span)) {
        fprintf(stderr, "--steps %s: use two cycles, the lower one first, as in 1000-2000\n", span);
        return false;
    }
    times->machine->on_step = stepped;
    return true;
}

/* --- the wire ------------------------------------------------------------------------------------
 */

void times_byte(struct times *times, uint64_t now, unsigned bus, const struct bus_circuit *circuit)
{
    struct times_sent *sent = &times->sent[bus];
    if (sent->bytes == 0) {
        sent->first = now;
        sent->idle = 0;
    } else {
        sent->idle += now - sent->last;
    }
    sent->bytes++;
    sent->last = uart_tx_end(&circuit->usart.tx);
}

void times_wire(struct times *times, uint64_t now, unsigned bus, const struct bus_circuit *circuit)
{
    struct times_sent *sent = &times->sent[bus];
    if (times->file && sent->bytes && now >= sent->last && !circuit->tx_enable &&
        circuit->listening) {
        fprintf(times->file, "sent %u %" PRIu64 " %" PRIu64 " %u %" PRIu64 " %" PRIu64 "\n", bus,
                sent->first, sent->last, sent->bytes, sent->idle, now - sent->last);
        sent->bytes = 0;
    }
}

/* --- a run ---------------------------------------------------------------------------------------
 */

bool times_open(struct times *times, struct machine *machine, const char *path)
{
    *times = (struct times){.path = path, .machine = machine, .cpu = &machine->cpu};
    times->file = fopen(path, "w");
    if (!times->file) {
        fprintf(stderr, "%s: %s\n", path, strerror(errno));
        return false;
    }
    machine->log_context = times;
    machine->on_interrupts = interrupts_changed;
    return true;
}

bool times_close(struct times *times, uint64_t now)
{
    FILE *file = times->file;
    if (!file) {
        return true;
    }
    for (unsigned i = 0; i < TIMES_VECTORS; i++) {
        const struct times_handler *handler = &times->handler[i];
        if (handler->times) {
            fprintf(file, "handler %u %" PRIu32 " %" PRIu64 " %" PRIu64 "\n", i, handler->times,
                    handler->cycles, handler->longest);
        }
    }
    fprintf(file, "off %" PRIu64 " %" PRIu64 "\n", times->longest_off, times->longest_off_at);
    fprintf(file, "run %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", now, times->cpu->in_handlers,
            times->cpu->asleep);
    times->file = 0;
    return files_close(file, times->path);
}
