/* SPDX-License-Identifier: MIT */
#include "rig.h"

#include <elf.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#define DATA_BASE 0x800000u // offset of the RAM in an AVR's ELF file
#define START_UP  (2000 * RIG_US)

static _Noreturn void die(const char *what, const char *which)
{
    fprintf(stderr, "faults: %s: %s\n", which, what);
    exit(2);
}

/* --- the program's RAM --- */

static uint32_t symbol(const struct image *image, const char *name)
{
    Elf32_Ehdr h;
    Elf32_Shdr table, names;
    memcpy(&h, image->file, sizeof(h));
    for (unsigned i = 0; i < h.e_shnum; i++) {
        memcpy(&table, image->file + h.e_shoff + i * sizeof(table), sizeof(table));
        if (table.sh_type != SHT_SYMTAB) {
            continue;
        }
        memcpy(&names, image->file + h.e_shoff + table.sh_link * sizeof(names), sizeof(names));
        for (unsigned at = 0; at < table.sh_size; at += sizeof(Elf32_Sym)) {
            Elf32_Sym found;
            memcpy(&found, image->file + table.sh_offset + at, sizeof(found));
            if (strcmp((char *)image->file + names.sh_offset + found.st_name, name) == 0) {
                return found.st_value - DATA_BASE;
            }
        }
    }
    die("no such symbol", name);
}

static void *in_ram(struct rig *rig, size_t offset)
{
    return &rig->bench.machine.avr->data[rig->job_at + offset];
}

/* --- taps --- */

static struct rig *the_rig; // a tap is called with the context of the function that it replaces
static void (*to_usart)(void *context, uint64_t now, const struct uart_frame *frame);
static void (*to_servos)(void *context, uint64_t now, const struct uart_frame *frame);
static void (*to_trace)(void *context, uint64_t now);
static void (*to_faults)(void *context, uint64_t now);
static void (*to_due)(void *fault_context, struct servo_node *node);
static void (*to_circuit)(void *context, enum usart_event event, uint64_t now);

static void record(struct tap *tap, uint64_t time, uint8_t byte, bool bad)
{
    if (tap->count < RIG_ROOM) {
        tap->bytes[tap->count] = (struct tap_byte){time, byte, bad};
    }
    tap->count++;
}

static void usart_received(void *context, uint64_t now, const struct uart_frame *frame)
{
    record(&the_rig->received, now, frame->byte, frame->framing_error);
    to_usart(context, now, frame);
}

static void servos_received(void *context, uint64_t now, const struct uart_frame *frame)
{
    record(&the_rig->servos_received, now, frame->byte, frame->framing_error);
    to_servos(context, now, frame);
}

static void controller_sends(void *context, uint64_t now)
{
    struct rig *rig = the_rig;
    const struct uart_tx *tx = &rig->bench.bus[0].circuit.usart.tx;
    record(&rig->sent, now, (uint8_t)(tx->frame >> 1), false);
    if (rig->hold_after != INT64_MIN) {
        schedule_at(&rig->bench.schedule, &rig->hold, now + (uint64_t)rig->hold_after);
        rig->hold_after = INT64_MIN;
    }
    to_faults(context, now);
}

static void circuit_changed(void *context, uint64_t now)
{
    static bool drove;
    bool drives = the_rig->bench.bus[0].circuit.tx_enable;
    if (drove && !drives) {
        the_rig->released = now;
    }
    drove = drives;
    to_trace(context, now);
}

static void usart_has_event(void *context, enum usart_event event, uint64_t now)
{
    the_rig->overruns += event == USART_OVERRUN;
    to_circuit(context, event, now);
}

static void reply_due(void *fault_context, struct servo_node *node)
{
    struct rig *rig = the_rig;
    const struct servo_reply *reply = &node->servo.reply;
    if (rig->answer_count < RIG_ANSWERS) {
        struct answer *answer = &rig->answers[rig->answer_count];
        answer->size = reply->size;
        memcpy(answer->bytes, reply->bytes, reply->size);
    }
    rig->answer_count++;
    to_due(fault_context, node);
}

static void tap_in(struct rig *rig)
{
    struct testbench_bus *bus = &rig->bench.bus[0];
    struct servo_receiver *receiver = bus->servos.receivers[SERVO_RESET_BAUD];
    to_usart = bus->circuit.usart.rx.on_byte;
    bus->circuit.usart.rx.on_byte = usart_received;
    to_servos = receiver->rx.on_byte;
    receiver->rx.on_byte = servos_received;
    to_trace = bus->circuit.on_change;
    bus->circuit.on_change = circuit_changed;
    to_faults = bus->circuit.on_byte;
    bus->circuit.on_byte = controller_sends;
    to_due = bus->servos.fault_on_reply;
    bus->servos.fault_on_reply = reply_due;
    to_circuit = bus->circuit.usart.on_event;
    bus->circuit.usart.on_event = usart_has_event;
}

/* --- the machine --- */

static void marked(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq;
    struct rig *rig = param;
    uint64_t now = rig_now(rig) + USART_WRITE_CYCLES;
    switch (value) {
    case JOB_BEGUN: rig->begun = now; break;
    case JOB_ENDED: rig->ended = now; break;
    case JOB_LOOKS: break;
    default:
        rig->ready = now;
        machine_stop(&rig->bench.machine);
        break;
    }
}

static void over(void *context, uint64_t now)
{
    struct rig *rig = context;
    (void)now;
    rig->timed_out = true;
    machine_stop(&rig->bench.machine);
}

static void raise_hold(void *context, uint64_t now)
{
    struct rig *rig = context;
    avr_t *avr = rig->bench.machine.avr;
    (void)now;
    uint8_t number = *(uint8_t *)in_ram(rig, offsetof(struct job_board, hold_vector));
    for (unsigned i = 0; i < avr->interrupts.vector_count; i++) {
        if (avr->interrupts.vector[i]->vector == number) {
            avr_raise_interrupt(avr, avr->interrupts.vector[i]);
        }
    }
}

static void handler_runs(void *context, uint64_t now, uint8_t vector)
{
    struct rig *rig = context;
    static uint8_t before;
    if (before == *(uint8_t *)in_ram(rig, offsetof(struct job_board, hold_vector)) &&
        vector != before) {
        rig->hold_until = now;
    }
    before = vector;
}

static void watch_marks(struct rig *rig)
{
    struct pin port;
    if (!pin_find(&port, rig->bench.machine.avr, 'B', 0)) {
        die("no port B", rig->options.board);
    }
    avr_irq_t *irq = port.port->io.irq + IOPORT_IRQ_REG_PORT;
    avr_irq_register_notify(irq, marked, rig);
}

/* Runs until the AVR program writes a mark, or for `cycles`. Returns false after `cycles`. A crash
 * ends `faults`. */
static bool run(struct rig *rig, uint64_t cycles)
{
    struct machine *machine = &rig->bench.machine;
    rig->timed_out = false;
    machine->stop = false;
    schedule_at(&rig->bench.schedule, &rig->limit, rig_now(rig) + cycles);
    enum machine_end end = machine_run(machine);
    schedule_cancel(&rig->bench.schedule, &rig->limit);
    if (end != MACHINE_STOPPED) {
        die(end == MACHINE_DONE ? "the program sleeps" : machine->crash, rig->options.elf);
    }
    return !rig->timed_out;
}

/* The console prints nothing but replies from then on. */
static void enter_mode_program(struct rig *rig)
{
    static const char line[] = "mode program\n";
    while (!usart_rxen(&rig->bench.host_link.usart)) {
        rig_pass(rig, START_UP);
    }
    rig_pass(rig, START_UP);
    host_link_send(&rig->bench.host_link, rig_now(rig), line, sizeof(line) - 1);
    rig_pass(rig, 50000 * RIG_US); // banner, line and reply take 14 ms
}

bool rig_open(struct rig *rig, const char *elf, const char *boards, const char *board,
              const char *servos, bool console)
{
    *rig = (struct rig){.hold_after = INT64_MIN};
    rig->options = (struct testbench_options){
        .elf = elf, .boards = boards, .board = board, .allow_duplicates = true, .exact = true};
    struct testbench_servos *list = &rig->options.servos[0];
    const char *wrong = ids_parse(servos, true, list->ids, &list->count);
    if (wrong) {
        die(wrong, servos);
    }
    the_rig = rig;
    if (!testbench_init(&rig->bench, &rig->options)) {
        return false;
    }
    rig->bench.rules.out = 0;
    event_init(&rig->limit, over, rig);
    event_init(&rig->hold, raise_hold, rig);
    rig->bench.machine.cpu.context = rig;
    tap_in(rig);
    if (!console) {
        rig->job_at = symbol(&rig->bench.machine.image, "job_board");
        rig->bench.machine.cpu.on_handler = handler_runs;
        watch_marks(rig);
    }
    rig_pass(rig, START_UP);
    if (console) {
        enter_mode_program(rig);
    }
    return true;
}

void rig_close(struct rig *rig)
{
    testbench_free(&rig->bench);
}

uint64_t rig_now(const struct rig *rig)
{
    return rig->bench.machine.avr->cycle;
}

struct servo_node *rig_node(struct rig *rig, unsigned index)
{
    return &rig->bench.bus[0].servos.node[index];
}

bool rig_tied(const struct rig *rig)
{
    return rig->bench.bus[0].circuit.wiring == BOARD_TIED;
}

void rig_forget(struct rig *rig)
{
    rig->sent.count = rig->received.count = 0;
    rig->overruns = 0;
    rig->answer_count = 0;
    memset(rig->bench.rules.breaches, 0, sizeof(rig->bench.rules.breaches));
}

void rig_pass(struct rig *rig, uint64_t cycles)
{
    while (run(rig, cycles)) {
        die("wrote a mark without a job", rig->options.elf);
    }
}

static void inject(struct rig *rig, uint64_t now, const char *text)
{
    const char *wrong = faults_order(&rig->bench.bus[0].faults, now, text);
    if (wrong) {
        die(wrong, text);
    }
}

void rig_order(struct rig *rig, const char *format, ...)
{
    char text[FAULT_TEXT_MAX];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    inject(rig, rig_now(rig), text);
}

static void inject_timed(void *context, uint64_t now)
{
    const struct timed_order *timed = context;
    inject(timed->rig, now, timed->text);
}

void rig_order_in(struct rig *rig, uint64_t cycles, const char *format, ...)
{
    unsigned i = 0;
    while (i + 1 < RIG_TIMED && event_armed(&rig->timed[i].event)) {
        i++;
    }
    struct timed_order *timed = &rig->timed[i];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(timed->text, sizeof(timed->text), format, arguments);
    va_end(arguments);
    timed->rig = rig;
    event_init(&timed->event, inject_timed, timed);
    schedule_at(&rig->bench.schedule, &timed->event, rig_now(rig) + cycles);
}

static bool is_quiet(const struct rig *rig)
{
    const struct testbench_bus *bus = &rig->bench.bus[0];
    for (unsigned i = 0; i < bus->servos.count; i++) {
        const struct servo_node *node = &bus->servos.node[i];
        if (node->driver.enabled || event_armed(&node->reply_delay)) {
            return false;
        }
    }
    return !bus->circuit.usart.tx.busy && !bus->faults.babble.busy;
}

bool rig_settle(struct rig *rig)
{
    for (unsigned i = 0; i < 50000; i++) {
        if (is_quiet(rig)) {
            return true;
        }
        rig_pass(rig, 20 * RIG_US);
    }
    return false;
}

void rig_begin(struct rig *rig, const struct job *job)
{
    memcpy(in_ram(rig, offsetof(struct job_board, job)), job, sizeof(*job));
    *(uint8_t *)in_ram(rig, offsetof(struct job_board, go)) = 1;
}

bool rig_wait(struct rig *rig, uint64_t cycles, struct job_outcome *outcome)
{
    bool done = run(rig, cycles);
    memcpy(outcome, in_ram(rig, offsetof(struct job_board, outcome)), sizeof(*outcome));
    return done;
}

void rig_hold(struct rig *rig, int64_t after, uint16_t loops)
{
    rig->hold_after = after;
    memcpy(in_ram(rig, offsetof(struct job_board, hold_loops)), &loops, sizeof(loops));
}

bool rig_listens(const struct rig *rig)
{
    const struct bus_circuit *circuit = &rig->bench.bus[0].circuit;
    bool holds = rig_tied(rig) ? usart_is_transmitting(&circuit->usart) : circuit->tx_enable;
    return !holds && circuit->listening;
}
