#include "machine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <simavr/avr_watchdog.h>

#define DATA_SPACE 0x10000u // what an AVR's pointers can reach
#define SOON       16       // cycles: enter a vector without a handler and jump to 0

static void crash(struct machine *machine, const char *what)
{
    if (!machine->crash[0]) {
        snprintf(machine->crash, sizeof(machine->crash), "%s at PC 0x%05x", what,
                 (unsigned)machine->pc);
    }
    machine->stop = true;
}

/* Every error that simavr logs is a crash of the firmware; its other messages are of no use here.
 */
static void log_message(struct avr_t *avr, const int level, const char *format, va_list arguments)
{
    if (!avr || !avr->custom.data || level != LOG_ERROR) {
        return;
    }
    struct machine *machine = avr->custom.data;
    char raw[160];
    char text[160];
    vsnprintf(raw, sizeof(raw), format, arguments);
    size_t used = 0;
    for (const char *c = raw; *c; c++) {
        if (*c == '\033') { // simavr writes in colours
            c += strcspn(c, "m");
            c -= *c == 0;
        } else if (*c != '\n') {
            text[used++] = *c;
        }
    }
    text[used] = 0;
    if (!strstr(text, "overrun")) { // of its own USART: no crash
        crash(machine, text);
    }
}

/* --- time ----------------------------------------------------------------------------------------
 */

static avr_cycle_count_t drive(struct avr_t *avr, avr_cycle_count_t when, void *param)
{
    (void)when;
    struct machine *machine = param;
    machine->driving = true;
    schedule_run_until(machine->schedule, avr->cycle);
    machine->driving = false;
    uint64_t next = schedule_next(machine->schedule);
    return next == SCHEDULE_NEVER ? 0 : next;
}

static void head_moved(void *owner, uint64_t time)
{
    struct machine *machine = owner;
    avr_t *avr = machine->avr;
    if (!machine->driving) {
        avr_cycle_timer_register(avr, time > avr->cycle ? time - avr->cycle : 0, drive, machine);
    }
}

static void sleep_callback(struct avr_t *avr, avr_cycle_count_t cycles)
{
    struct machine *machine = avr->custom.data;
    cpu_slept(&machine->cpu, cycles);
}

/* A reset throws all cycle timers away, ours included. */
static void was_reset(struct avr_io_t *io)
{
    struct machine *machine = io->avr->custom.data;
    machine->fresh = true;
    cpu_reset(&machine->cpu);
    if (machine->on_reset) {
        machine->on_reset(machine->owner, machine->avr->cycle);
    }
    uint64_t next = schedule_next(machine->schedule);
    machine->driving = false;
    if (next != SCHEDULE_NEVER) {
        head_moved(machine, next);
    }
}

static void watch_resets(struct machine *machine)
{
    machine->reset_watch = (avr_io_t){.kind = "cds55xx", .reset = was_reset, .avr = machine->avr};
    avr_io_t **tail = &machine->avr->io_port;
    while (*tail) {
        tail = &(*tail)->next;
    }
    *tail = &machine->reset_watch;
}

/* --- set-up --------------------------------------------------------------------------------------
 */

/* simavr notices a write beyond the RAM and then makes it: give it room. */
static void widen_data(avr_t *avr)
{
    size_t used = avr->ramend + 1u;
    avr->data = realloc(avr->data, DATA_SPACE);
    if (!avr->data) {
        fputs("out of memory\n", stderr);
        abort();
    }
    memset(avr->data + used, 0, DATA_SPACE - used);
}

bool machine_init(struct machine *machine, struct schedule *schedule, const char *mcu,
                  uint32_t clock_Hz, const char *elf, bool exact)
{
    *machine = (struct machine){.schedule = schedule, .fresh = true};
    if (!image_open(&machine->image, elf)) {
        return false;
    }
    avr_global_logger_set(log_message);
    avr_t *avr = avr_make_mcu_by_name(mcu);
    if (!avr) {
        fprintf(stderr, "%s: simavr does not know this chip\n", mcu);
        return false;
    }
    machine->avr = avr;
    avr_init(avr);
    avr->frequency = clock_Hz;
    widen_data(avr);
    if (!image_load(&machine->image, avr, mcu)) {
        return false;
    }
    avr->codeend = machine->image.code_end;
    avr->custom.data = machine;
    avr->sleep = sleep_callback;
    cpu_init(&machine->cpu, avr, exact);
    watch_resets(machine);
    schedule->on_earlier = head_moved;
    schedule->owner = machine;
    return true;
}

/* What avr_terminate() forgets: the IRQs of vectors, of registers, and of a watchdog without
 * vector. */
static void free_irqs(avr_t *avr)
{
    for (unsigned i = 0; i < avr->interrupts.vector_count; i++) {
        avr_free_irq(avr->interrupts.vector[i]->irq, AVR_INT_IRQ_COUNT);
    }
    avr_free_irq(avr->interrupts.irq, AVR_INT_IRQ_COUNT);
    for (unsigned i = 0; i < MAX_IOs; i++) {
        avr_free_irq(avr->io[i].irq, AVR_IOMEM_IRQ_ALL + 1);
    }
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "watchdog") == 0) {
            avr_free_irq(((avr_watchdog_t *)io)->watchdog.irq, AVR_INT_IRQ_COUNT);
        }
    }
}

void machine_free(struct machine *machine)
{
    avr_t *avr = machine->avr;
    image_close(&machine->image);
    if (avr) {
        free_irqs(avr);
        avr_terminate(avr);
        free(avr->irq_pool.irq);
        free(avr);
    }
}

/* --- running -------------------------------------------------------------------------------------
 */

void machine_stop(struct machine *machine)
{
    machine->stop = true;
}

static void check_jump(struct machine *machine, bool after_reset)
{
    avr_t *avr = machine->avr;
    const struct cpu *cpu = &machine->cpu;
    if (avr->pc == 0 && !after_reset) {
        char what[80] = "jump to 0 (null function pointer, torn stack)";
        if (cpu->depth && avr->cycle - cpu->latest <= SOON) {
            snprintf(what, sizeof(what), "interrupt vector %u has no handler",
                     cpu->vectors[cpu->depth - 1]);
        }
        crash(machine, what);
    } else if (avr->pc >= machine->image.code_end) {
        crash(machine, "jump out of the code");
    }
}

enum machine_end machine_run(struct machine *machine)
{
    avr_t *avr = machine->avr;
    while (!machine->stop) {
        machine->fresh = false;
        machine->pc = avr->pc;
        int state = avr_run(avr);
        if (avr->interrupt_state < 0) {
            cpu_stepped(&machine->cpu);
        }
        if (state == cpu_Done) {
            return MACHINE_DONE;
        }
        if (state == cpu_Crashed) {
            crash(machine, "crash");
        }
        if (avr->pc == 0 || avr->pc >= machine->image.code_end) {
            check_jump(machine, machine->fresh);
        }
    }
    return machine->crash[0] ? MACHINE_CRASHED : MACHINE_STOPPED;
}
