/* SPDX-License-Identifier: MIT */
#include "output/cycle_log.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "output/files.h"

/* --- interrupts off --- */

/* Interrupts were off until `now`. */
static void record_off(struct cycle_log *log, uint64_t now)
{
    if (now - log->off_since > log->longest_off) {
        log->longest_off = now - log->off_since;
        log->longest_off_since = log->off_since;
    }
}

/* The machine calls this after the instruction that turned interrupts on or off. The entry of a
 * handler turns them off too: entered() records that. */
static void interrupts_changed(void *context, bool on)
{
    struct cycle_log *log = context;
    uint64_t now = log->cpu->avr->cycle;
    if (on && log->interrupts_off) {
        record_off(log, now);
    }
    if (!on && !log->interrupts_off) {
        log->off_since = now;
    }
    log->interrupts_off = !on;
}

/* --- handlers --- */

static void entered(struct cycle_log *log, uint64_t now)
{
    const struct cpu *cpu = log->cpu;
    log->running[log->depth++] =
        (struct running_handler){.vector = cpu->vectors[cpu->depth - 1], .entered = now};
    log->interrupts_off = true;
    log->off_since = now;
}

/* `now` is the start of RETI: its cycles (2 and the size of the PC) are added here. */
static void left(struct cycle_log *log, uint64_t now)
{
    const struct running_handler *running = &log->running[--log->depth];
    struct handler_cycles *handler = &log->handler[running->vector % CYCLE_LOG_VECTORS];
    uint64_t took = now + 2u + log->cpu->avr->address_size - running->entered;
    uint64_t own = took - running->nested;
    handler->count++;
    handler->cycles += own;
    handler->longest = own > handler->longest ? own : handler->longest;
    if (log->depth) {
        log->running[log->depth - 1].nested += took;
    }
}

/* The run ends, or the chip is reset. A handler that has interrupts off counts as far as it has
 * come. Interrupts that the main program has turned off do not count: a firmware ends in this way.
 */
static void cut_off(struct cycle_log *log, uint64_t now)
{
    if (log->depth && log->interrupts_off) {
        record_off(log, now);
    }
    log->depth = 0;
    log->interrupts_off = false;
}

void cycle_log_handler(struct cycle_log *log, uint64_t now)
{
    if (!log->file) {
        return;
    }
    if (log->machine->just_reset) {
        cut_off(log, now);
    } else if (log->cpu->depth > log->depth) {
        entered(log, now);
    } else {
        left(log, now);
    }
}

/* --- --stamp: changes of a port's pins --- */

static uint8_t port_level(const struct pin *pin)
{
    const uint8_t *data = pin->port->io.avr->data;
    return data[pin->port->r_ddr] & data[pin->port->r_port];
}

static void stamp_changed(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq, (void)value;
    struct cycle_log *log = param;
    uint8_t level = port_level(&log->stamp);
    unsigned changed = level ^ log->stamp_level;
    for (unsigned bit = 0; bit < 8; bit++) {
        if (changed >> bit & 1) {
            fprintf(log->file, "pin %" PRIu64 " %u %d %" PRIu64 "\n", log->cpu->avr->cycle, bit,
                    level >> bit & 1, log->cpu->in_handlers);
        }
    }
    log->stamp_level = level;
}

static bool watch_port(struct cycle_log *log, const char *port)
{
    if (!log->file) {
        fputs("--stamp is for --times\n", stderr);
        return false;
    }
    if (strlen(port) != 1 || !pin_find(&log->stamp, log->cpu->avr, port[0], 0)) {
        fprintf(stderr, "--stamp %s: the chip has no such port; wanted: its letter, as in B\n",
                port);
        return false;
    }
    pin_watch(&log->stamp, stamp_changed, log);
    return true;
}

/* --- --steps: instructions --- */

static void stepped(void *context, uint64_t now, uint32_t pc)
{
    const struct cycle_log *log = context;
    if (now >= log->steps_from && now < log->steps_to) {
        fprintf(log->file, "step %" PRIu64 " %" PRIu32 "\n", now, pc);
    }
}

/* Accepts digits only, up to UINT64_MAX. Returns the text after the number, or 0. */
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

static bool parse_span(struct cycle_log *log, const char *span)
{
    const char *rest = parse_cycle(span, &log->steps_from);
    rest = rest && *rest == '-' ? parse_cycle(rest + 1, &log->steps_to) : 0;
    return rest && !*rest && log->steps_from < log->steps_to;
}

static bool watch_steps(struct cycle_log *log, const char *span)
{
    if (!log->file) {
        fputs("--steps is for --times\n", stderr);
        return false;
    }
    if (!parse_span(log, span)) {
        fprintf(stderr, "--steps %s: use two cycles, the lower one first, as in 1000-2000\n", span);
        return false;
    }
    log->machine->on_step = stepped;
    return true;
}

/* --- transmissions --- */

void cycle_log_byte(struct cycle_log *log, uint64_t now, unsigned bus,
                    const struct bus_circuit *circuit)
{
    struct transmission *sent = &log->transmission[bus];
    if (sent->bytes == 0) {
        sent->start = now;
        sent->idle = 0;
    } else {
        sent->idle += now - sent->end;
    }
    sent->bytes++;
    sent->end = uart_tx_end(&circuit->usart.tx);
}

/* A transmission ends when the driver is off and the receiver is on. */
void cycle_log_circuit(struct cycle_log *log, uint64_t now, unsigned bus,
                       const struct bus_circuit *circuit)
{
    struct transmission *sent = &log->transmission[bus];
    if (log->file && sent->bytes && now >= sent->end && !circuit->tx_enable && circuit->listening) {
        fprintf(log->file, "sent %u %" PRIu64 " %" PRIu64 " %u %" PRIu64 " %" PRIu64 "\n", bus,
                sent->start, sent->end, sent->bytes, sent->idle, now - sent->end);
        sent->bytes = 0;
    }
}

/* --- --mark: how long a pin is high --- */

static void timer_starts(struct pin_timer *timer, const struct cpu *cpu)
{
    timer->high = true;
    timer->rose = cpu->avr->cycle;
    timer->in_handlers = cpu->in_handlers;
    timer->count++;
}

static void timer_stops(struct pin_timer *timer, const struct cpu *cpu, uint64_t now)
{
    uint64_t took = now - timer->rose - (cpu->in_handlers - timer->in_handlers);
    timer->high = false;
    timer->cycles += took;
    timer->longest = took > timer->longest ? took : timer->longest;
}

static void mark_changed(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq, (void)value;
    struct cycle_log *log = param;
    struct pin_timer *timer = &log->timer;
    bool high = pin_state(&timer->pin) == PIN_HIGH;
    if (high && !timer->high) {
        timer_starts(timer, log->cpu);
    } else if (!high && timer->high) {
        timer_stops(timer, log->cpu, log->cpu->avr->cycle);
    }
}

static bool watch_mark(struct cycle_log *log, const char *name)
{
    log->timer.name = name;
    if (strlen(name) != 2 ||
        !pin_find(&log->timer.pin, log->cpu->avr, name[0], (unsigned)(name[1] - '0'))) {
        fprintf(stderr, "--mark %s: the chip has no such pin; wanted: port and bit, as in B0\n",
                name);
        return false;
    }
    pin_watch(&log->timer.pin, mark_changed, log);
    return true;
}

void cycle_log_report(struct cycle_log *log, uint64_t now, FILE *out)
{
    struct pin_timer *timer = &log->timer;
    if (!timer->name) {
        return;
    }
    if (timer->high) {
        timer_stops(timer, log->cpu, now);
    }
    fprintf(out,
            "mark:    P%s high %.2f %% of the time without handlers; %" PRIu32 " times, %" PRIu64
            " cycles at most, %" PRIu64 " in all\n",
            timer->name, now ? 100.0 * (double)timer->cycles / (double)now : 0.0, timer->count,
            timer->longest, timer->cycles);
}

/* --- a run --- */

static bool open_file(struct cycle_log *log, const char *path)
{
    log->path = path;
    log->file = files_create(path);
    log->machine->log_context = log;
    log->machine->on_interrupts = interrupts_changed;
    return log->file != 0;
}

bool cycle_log_open(struct cycle_log *log, struct machine *machine,
                    const struct cycle_log_options *options)
{
    *log = (struct cycle_log){.machine = machine, .cpu = &machine->cpu};
    return (!options->mark || watch_mark(log, options->mark)) &&
           (!options->times || open_file(log, options->times)) &&
           (!options->stamp || watch_port(log, options->stamp)) &&
           (!options->steps || watch_steps(log, options->steps));
}

bool cycle_log_close(struct cycle_log *log, uint64_t now)
{
    FILE *file = log->file;
    if (!file) {
        return true;
    }
    cut_off(log, now);
    for (unsigned i = 0; i < CYCLE_LOG_VECTORS; i++) {
        const struct handler_cycles *handler = &log->handler[i];
        if (handler->count) {
            fprintf(file, "handler %u %" PRIu32 " %" PRIu64 " %" PRIu64 "\n", i, handler->count,
                    handler->cycles, handler->longest);
        }
    }
    fprintf(file, "off %" PRIu64 " %" PRIu64 "\n", log->longest_off, log->longest_off_since);
    fprintf(file, "run %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", now, log->cpu->in_handlers,
            log->cpu->asleep);
    log->file = 0;
    return files_close(file, log->path);
}
