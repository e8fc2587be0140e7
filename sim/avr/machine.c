/* SPDX-License-Identifier: MIT */
#include "avr/machine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <simavr/avr_watchdog.h>
#include <simavr/sim_core.h>

#include "avr/timer_flags.h"
#include "memory.h"

#define DATA_SPACE    0x10000u // addresses that an AVR's pointers can reach
#define VECTOR_CYCLES 16       // cycles to enter a vector without a handler and jump to 0

static void crash(struct machine *machine, const char *what)
{
    if (!machine->crash[0]) {
        snprintf(machine->crash, sizeof(machine->crash), "%s at PC 0x%05x", what,
                 (unsigned)machine->pc);
    }
    machine->stop = true;
}

/* Treats each error that simavr logs as a crash of the firmware, and drops its other messages. */
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
        if (*c == '\033') { // simavr prints in colours
            c += strcspn(c, "m");
            c -= *c == 0;
        } else if (*c != '\n') {
            text[used++] = *c;
        }
    }
    text[used] = 0;
    if (!strstr(text, "overrun")) { // an overrun of simavr's own USART is no crash
        crash(machine, text);
    }
}

/* --- time --- */

static avr_cycle_count_t run_due_events(struct avr_t *avr, avr_cycle_count_t when, void *param)
{
    (void)when;
    struct machine *machine = param;
    machine->in_events = true;
    schedule_run_until(machine->schedule, avr->cycle);
    machine->in_events = false;
    uint64_t next = schedule_next(machine->schedule);
    return next == SCHEDULE_NEVER ? 0 : next;
}

static void next_event_moved(void *context, uint64_t time)
{
    struct machine *machine = context;
    avr_t *avr = machine->avr;
    if (!machine->in_events) {
        avr_cycle_timer_register(avr, time > avr->cycle ? time - avr->cycle : 0, run_due_events,
                                 machine);
    }
}

static void sleep_callback(struct avr_t *avr, avr_cycle_count_t cycles)
{
    struct machine *machine = avr->custom.data;
    cpu_slept(&machine->cpu, cycles);
}

/* --- reset --- */

static uint8_t *flags(const struct machine *machine)
{
    return &machine->avr->data[machine->avr->reset_flags.porf.reg];
}

static avr_watchdog_t *watchdog(avr_t *avr)
{
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "watchdog") == 0) {
            return (avr_watchdog_t *)io;
        }
    }
    return 0;
}

/* A watchdog stays on after its reset on chips where it has an interrupt mode. On an ATmega128,
 * which has no WDP3, a reset clears WDTCR (data sheet, WDTCR). simavr leaves the watchdog on in all
 * chips. */
static void stop_old_watchdog(avr_t *avr)
{
    avr_watchdog_t *wdt = watchdog(avr);
    if (!wdt || wdt->wdp[3].reg || !avr_regbit_get(avr, wdt->wde)) {
        return;
    }
    avr_io_write_t write = avr->io[AVR_DATA_TO_IO(wdt->wde.reg)].w.c;
    avr_regbit_clear(avr, wdt->wdrf); // WDRF keeps WDE set
    write(avr, wdt->wde.reg, (uint8_t)(1u << wdt->wdce.bit | 1u << wdt->wde.bit), wdt);
    write(avr, wdt->wde.reg, 0, wdt);
    avr_regbit_clear(avr, wdt->wdce);
    avr_regbit_set(avr, wdt->wdrf);
}

/* A reset of simavr drops all cycle timers, also that of the event queue. */
static void was_reset(struct avr_io_t *io)
{
    struct machine *machine = io->avr->custom.data;
    machine->just_reset = true;
    machine->interrupts = false;
    cpu_reset(&machine->cpu);
    eeprom_model_reset(&machine->eeprom);
    if (machine->cpu.exact) {
        stop_old_watchdog(machine->avr);
    }
    *flags(machine) |= machine->flags;
    if (machine->on_reset) {
        machine->on_reset(machine->context, machine->avr->cycle);
    }
    uint64_t next = schedule_next(machine->schedule);
    machine->in_events = false;
    if (next != SCHEDULE_NEVER) {
        next_event_moved(machine, next);
    }
}

static void hook_resets(struct machine *machine)
{
    machine->reset_hook = (avr_io_t){.kind = "cds55xx", .reset = was_reset, .avr = machine->avr};
    avr_io_t **tail = &machine->avr->io_port;
    while (*tail) {
        tail = &(*tail)->next;
    }
    *tail = &machine->reset_hook;
}

void machine_reset(struct machine *machine, enum machine_reset cause)
{
    machine->reset_due |= 1u << cause;
}

/* Makes simavr's watchdog do what it does after its own timeout. */
static void force_watchdog(struct machine *machine)
{
    avr_watchdog_t *wdt = watchdog(machine->avr);
    if (wdt) {
        wdt->reset_context.wdrf = 1;
        wdt->reset_context.avr_run = machine->run;
    }
}

/* --- a hang --- */

void machine_hang(struct machine *machine)
{
    machine->hang_due = true;
}

/* Replaces the next instruction of the main program by a jump to itself, at a point where
 * interrupts are on. */
static void hang(struct machine *machine)
{
    avr_t *avr = machine->avr;
    if (machine->cpu.depth || !avr->sreg[S_I]) {
        return;
    }
    machine->hang_due = false;
    machine->hangs = true;
    machine->hang_at = avr->pc;
    memcpy(machine->hang_code, avr->flash + avr->pc, sizeof(machine->hang_code));
    memcpy(avr->flash + avr->pc, (uint8_t[]){0xFF, 0xCF}, sizeof(machine->hang_code));
}

static void end_hang(struct machine *machine)
{
    if (machine->hangs) {
        memcpy(machine->avr->flash + machine->hang_at, machine->hang_code,
               sizeof(machine->hang_code));
    }
    machine->hangs = machine->hang_due = false;
}

/* The flags of earlier resets stay until the firmware or a loss of power clears them. */
static void reset(struct machine *machine)
{
    avr_t *avr = machine->avr;
    unsigned due = machine->reset_due;
    machine->reset_due = 0;
    end_hang(machine);
    machine->flags = *flags(machine) & ((1u << MACHINE_RESETS) - 1u);
    if (!due) {
        return; // the watchdog: simavr does the reset itself
    }
    if (due & (1u << MACHINE_POWER_ON | 1u << MACHINE_BROWN_OUT)) {
        eeprom_model_lose_power(&machine->eeprom, avr->cycle);
    }
    if (due & 1u << MACHINE_POWER_ON) {
        due = 1u << MACHINE_POWER_ON;
        machine->flags = 0;
        memset(avr->data, 0, avr->ramend + 1u);
    }
    if (due & 1u << MACHINE_WATCHDOG) {
        force_watchdog(machine);
    }
    machine->flags |= (uint8_t)due;
    avr->run = machine->run;
    avr_reset(avr);
}

/* --- set-up --- */

/* simavr detects a write beyond the RAM and then makes it. The larger buffer keeps that write
 * harmless. */
static void widen_data(avr_t *avr)
{
    size_t used = avr->ramend + 1u;
    avr->data = memory_checked(realloc(avr->data, DATA_SPACE));
    memset(avr->data + used, 0, DATA_SPACE - used);
}

bool machine_init(struct machine *machine, struct schedule *schedule, const char *mcu,
                  const char *core, uint32_t clock_Hz, const char *elf, bool exact)
{
    *machine = (struct machine){.schedule = schedule, .just_reset = true};
    if (!image_open(&machine->image, elf)) {
        return false;
    }
    avr_global_logger_set(log_message);
    avr_t *avr = avr_make_mcu_by_name(core);
    if (!avr) {
        fprintf(stderr, "%s: simavr does not know this chip\n", core);
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
    machine->run = avr->run;
    cpu_init(&machine->cpu, avr, exact);
    if (exact) {
        timer_flags_init(avr);
    }
    eeprom_model_init(&machine->eeprom, avr, schedule, exact);
    hook_resets(machine);
    schedule->on_earlier = next_event_moved;
    schedule->context = machine;
    return true;
}

/* Frees what avr_terminate() does not free: the IRQs of vectors, of registers, and of a watchdog
 * without a vector. */
static void free_irqs(avr_t *avr)
{
    for (unsigned i = 0; i < avr->interrupts.vector_count; i++) {
        avr_free_irq(avr->interrupts.vector[i]->irq, AVR_INT_IRQ_COUNT);
    }
    avr_free_irq(avr->interrupts.irq, AVR_INT_IRQ_COUNT);
    for (unsigned i = 0; i < MAX_IOs; i++) {
        avr_free_irq(avr->io[i].irq, AVR_IOMEM_IRQ_ALL + 1);
    }
    avr_watchdog_t *wdt = watchdog(avr);
    if (wdt) {
        avr_free_irq(wdt->watchdog.irq, AVR_INT_IRQ_COUNT);
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

/* --- running --- */

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
        if (cpu->depth && avr->cycle - cpu->latest <= VECTOR_CYCLES) {
            snprintf(what, sizeof(what), "interrupt vector %u has no handler",
                     cpu->vectors[cpu->depth - 1]);
        }
        crash(machine, what);
    } else if (avr->pc >= machine->image.code_end) {
        crash(machine, "jump out of the code");
    }
}

static void interrupts_changed(struct machine *machine)
{
    machine->interrupts = machine->avr->sreg[S_I];
    machine->interrupts_were_on = true;
    if (machine->on_interrupts) {
        machine->on_interrupts(machine->log_context, machine->interrupts);
    }
}

/* What avr_callback_run_raw() of simavr 1.6 does, at 9/10 of its CPU time: that looks at the timers
 * after each instruction, and most instructions reach none. It stays for sleep, and for a reset by
 * the watchdog. */
static int run_instruction(struct machine *machine)
{
    avr_t *avr = machine->avr;
    if (avr->state != cpu_Running || avr->run != machine->run) {
        return avr_run(avr);
    }
    avr_flashaddr_t next = avr_run_one(avr);
    if (avr->state == cpu_Sleeping) {
        avr->pc = next;
        return avr_run(avr);
    }
    const avr_cycle_timer_slot_t *first = avr->cycle_timers.timer;
    if (first && first->when <= avr->cycle) {
        avr_cycle_timer_process(avr);
    }
    avr->pc = next;
    if (avr->interrupt_state && avr->state == cpu_Running) {
        avr_service_interrupts(avr);
    }
    return avr->state;
}

static enum machine_end run(struct machine *machine)
{
    avr_t *avr = machine->avr;
    while (!machine->stop) {
        if (machine->reset_due || avr->run != machine->run) {
            reset(machine);
        }
        if (machine->gdb && !gdb_may_run(machine->gdb)) {
            break;
        }
        if (machine->hang_due) {
            hang(machine);
        }
        machine->just_reset = false;
        machine->pc = avr->pc;
        if (machine->on_step) {
            machine->on_step(machine->log_context, avr->cycle, avr->pc);
        }
        int state = run_instruction(machine);
        if (avr->interrupt_state < 0) {
            cpu_stepped(&machine->cpu);
        }
        if (machine->interrupts != avr->sreg[S_I]) {
            interrupts_changed(machine);
        }
        if (state == cpu_Done) {
            return MACHINE_DONE;
        }
        if (state == cpu_Crashed) {
            crash(machine, "crash");
        }
        if (avr->pc == 0 || avr->pc >= machine->image.code_end) {
            check_jump(machine, machine->just_reset);
        }
    }
    return machine->crash[0] ? MACHINE_CRASHED : MACHINE_STOPPED;
}

enum machine_end machine_run(struct machine *machine)
{
    enum machine_end end = run(machine);
    if (machine->gdb) {
        gdb_ended(machine->gdb, end == MACHINE_CRASHED);
    }
    return end;
}
