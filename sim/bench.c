#include "bench.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

/* --- who tells whom ------------------------------------------------------------------------------
 */

static void wire_changed(void *owner, uint64_t now)
{
    struct bench_bus *bus = owner;
    bus_trace_wire(&bus->trace, now);
}

static void servo_byte(void *owner, uint64_t now, uint64_t end)
{
    struct bench_bus *bus = owner;
    wire_servo_byte(&bus->wire, now, end);
}

static void servo_talks(void *owner, uint64_t now, const struct servo_node *node)
{
    struct bench_bus *bus = owner;
    bus_trace_servo(&bus->trace, now, node);
}

static void handler_runs(void *owner, uint64_t now, uint8_t vector)
{
    struct bench *bench = owner;
    vcd_change(&bench->vcd, bench->handler, now, vector);
}

static void was_reset(void *owner, uint64_t now)
{
    struct bench *bench = owner;
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        wire_reset(&bench->bus[i].wire, now);
    }
    if (bench->board.has_host) {
        usart_reset(&bench->host.usart, now);
    }
}

static void host_byte(void *owner, uint64_t now, uint8_t byte)
{
    struct bench *bench = owner;
    char text = (char)byte;
    switch (bench->options->host) {
    case BENCH_HOST_SCRIPT: script_hear(&bench->script, now, byte); break;
    case BENCH_HOST_PTY: pty_say(&bench->pty, &text, 1); break;
    case BENCH_HOST_STDOUT: fputc(byte, stdout); break;
    case BENCH_HOST_NONE: break;
    }
}

static size_t pty_room(void *owner)
{
    struct bench *bench = owner;
    return host_room(&bench->host);
}

static void pty_bytes(void *owner, uint64_t now, const char *bytes, size_t size)
{
    struct bench *bench = owner;
    host_say(&bench->host, now, bytes, size);
    fflush(stdout);
}

static void time_is_over(void *owner, uint64_t now)
{
    struct bench *bench = owner;
    (void)now;
    machine_stop(&bench->machine);
}

/* --- what a script does --------------------------------------------------------------------------
 */

static bool script_ready(void *owner)
{
    struct bench *bench = owner;
    return usart_rxen(&bench->host.usart);
}

static void script_say(void *owner, uint64_t now, const char *bytes, size_t size)
{
    struct bench *bench = owner;
    host_say(&bench->host, now, bytes, size);
}

static void script_servos(void *owner, uint64_t now, const uint8_t *ids, unsigned count)
{
    struct bench *bench = owner;
    struct bench_bus *bus = &bench->bus[0];
    servos_replace(&bus->servos, now, ids, count);
    for (unsigned i = 0; i < count; i++) { // so that the signals are in the order of the list
        bus_trace_servo(&bus->trace, now, &bus->servos.node[i]);
    }
    motion_block(&bench->motion, now);
}

static void script_power(void *owner, uint64_t now, bool on)
{
    struct bench *bench = owner;
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        servos_power(&bench->bus[i].servos, now, on);
    }
}

static void script_echo(void *owner, bool on)
{
    struct bench *bench = owner;
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        bench->bus[i].transcript.echo = on ? stdout : 0;
    }
}

static void script_outcome(void *owner, uint64_t now, enum script_outcome outcome, const char *what)
{
    static const enum rule rule[] = {
        [SCRIPT_UNEXPECTED_ERROR] = RULE_REPLY_WAS_ERROR,
        [SCRIPT_UNEXPECTED_OK] = RULE_REPLY_WAS_OK,
        [SCRIPT_SILENCE] = RULE_SCRIPT_UNFINISHED,
    };
    struct bench *bench = owner;
    if (outcome != SCRIPT_GOOD) {
        rules_break(&bench->rules, rule[outcome], now, "%s:%u: %s%s", bench->script.path,
                    script_line_number(&bench->script), what,
                    outcome == SCRIPT_SILENCE ? ": no reply" : "");
    }
}

static void script_finished(void *owner, uint64_t now)
{
    struct bench *bench = owner;
    (void)now;
    machine_stop(&bench->machine);
}

static const struct script_world script_world = {
    .ready = script_ready,
    .say = script_say,
    .servos = script_servos,
    .power = script_power,
    .echo = script_echo,
    .outcome = script_outcome,
    .finished = script_finished,
};

/* --- set-up --------------------------------------------------------------------------------------
 */

static bool open_transcript(struct bench *bench)
{
    const char *path = bench->options->transcript;
    if (!path) {
        return true;
    }
    bench->transcript = fopen(path, "w");
    if (!bench->transcript) {
        fprintf(stderr, "%s: %s\n", path, strerror(errno));
    }
    return bench->transcript != 0;
}

static bool init_bus(struct bench *bench, unsigned index)
{
    struct bench_bus *bus = &bench->bus[index];
    uint32_t clock_Hz = bench->board.clock_Hz;
    bus->bench = bench;
    if (!wire_init(&bus->wire, &bench->machine, &bench->board.bus[index], bench->options->exact,
                   &bench->rules)) {
        return false;
    }
    transcript_init(&bus->transcript, &bench->schedule, &bus->wire.sig, &bus->wire.to_sig);
    bus->transcript.controller_talker = &bus->wire.usart.txd;
    bus->transcript.file = bench->transcript;
    servos_init(&bus->servos, &bench->schedule, &bus->wire.sig, clock_Hz);
    bus_trace_init(&bus->trace, &bench->vcd, index, &bus->wire);
    bus->wire.owner = bus;
    bus->wire.on_change = wire_changed;
    bus->servos.owner = bus;
    bus->servos.on_byte = servo_byte;
    bus->servos.on_talk = servo_talks;
    return true;
}

static bool init_host(struct bench *bench)
{
    const struct bench_options *options = bench->options;
    if (!bench->board.has_host) {
        if (options->host != BENCH_HOST_NONE) {
            fprintf(stderr, "%s: the board has no host link: no --script, no --host\n",
                    options->board);
        }
        return options->host == BENCH_HOST_NONE;
    }
    if (!host_init(&bench->host, &bench->machine, bench->board.host_usart, bench->board.host_baud,
                   options->exact)) {
        return false;
    }
    bench->host.owner = bench;
    bench->host.on_byte = host_byte;
    if (options->host == BENCH_HOST_SCRIPT) {
        bench->world = script_world;
        bench->world.owner = bench;
        script_start(&bench->script, &bench->schedule, bench->board.clock_Hz, &bench->world,
                     stdout);
        bench->script.echo = options->echo;
    }
    if (options->host == BENCH_HOST_PTY) {
        if (!pty_open(&bench->pty, &bench->schedule, bench->board.clock_Hz)) {
            return false;
        }
        bench->pty.owner = bench;
        bench->pty.room = pty_room;
        bench->pty.on_bytes = pty_bytes;
        printf("%s\n", bench->pty.path);
        fflush(stdout);
    }
    return true;
}

static bool init_instruments(struct bench *bench)
{
    const struct bench_options *options = bench->options;
    uint32_t clock_Hz = bench->board.clock_Hz;
    if (!open_transcript(bench) ||
        (options->vcd && !vcd_open(&bench->vcd, options->vcd, clock_Hz)) ||
        (options->csv && !motion_open(&bench->motion, options->csv, &bench->schedule,
                                      &bench->bus[0].servos, clock_Hz))) {
        return false;
    }
    bench->handler = vcd_signal(&bench->vcd, "cpu_handler_vector", 8);
    bench->machine.cpu.owner = bench;
    bench->machine.cpu.on_handler = handler_runs;
    return true;
}

static void set_limit(struct bench *bench)
{
    event_init(&bench->limit, time_is_over, bench);
    if (bench->options->seconds > 0) {
        double cycles = bench->options->seconds * bench->board.clock_Hz;
        schedule_at(&bench->schedule, &bench->limit, (uint64_t)cycles);
    }
}

bool bench_init(struct bench *bench, const struct bench_options *options)
{
    *bench = (struct bench){.options = options, .pty = {.master = -1, .slave = -1}};
    schedule_init(&bench->schedule);
    if (options->script && !script_read(&bench->script, options->script)) {
        return false;
    }
    if (!board_read(&bench->board, options->boards, options->board)) {
        return false;
    }
    rules_init(&bench->rules, bench->board.clock_Hz, stdout);
    if (!machine_init(&bench->machine, &bench->schedule, bench->board.mcu, bench->board.clock_Hz,
                      options->elf, options->exact) ||
        !init_instruments(bench)) {
        return false;
    }
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        if (!init_bus(bench, i)) {
            return false;
        }
    }
    bench->machine.owner = bench;
    bench->machine.on_reset = was_reset;
    script_servos(bench, 0, options->ids, options->servos);
    script_echo(bench, options->echo);
    set_limit(bench);
    return init_host(bench);
}

/* --- run and report ------------------------------------------------------------------------------
 */

static const char *why_unfinished(const struct bench *bench)
{
    if (bench->cpu_done) {
        return "the firmware sleeps with interrupts off";
    }
    bool over = bench->options->seconds > 0 && !event_armed(&bench->limit);
    return over ? "--seconds were over" : "interrupted";
}

bool bench_run(struct bench *bench)
{
    enum machine_end end = machine_run(&bench->machine);
    bench->end = bench->machine.avr->cycle;
    bench->cpu_done = end == MACHINE_DONE;
    if (end == MACHINE_CRASHED) {
        rules_break(&bench->rules, RULE_CRASH, bench->end, "%s", bench->machine.crash);
    }
    if (bench->script.text && !bench->script.done && end != MACHINE_CRASHED) {
        rules_break(&bench->rules, RULE_SCRIPT_UNFINISHED, bench->end, "%s:%u: %s",
                    bench->script.path, script_line_number(&bench->script), why_unfinished(bench));
    }
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        transcript_end(&bench->bus[i].transcript);
    }
    return rules_broken(&bench->rules) == 0;
}

static double percent(uint64_t part, uint64_t whole)
{
    return whole ? 100.0 * (double)part / (double)whole : 0.0;
}

void bench_report(const struct bench *bench, FILE *out)
{
    const struct cpu *cpu = &bench->machine.cpu;
    fprintf(out, "time:    %.6f s simulated%s\n", (double)bench->end / bench->board.clock_Hz,
            bench->cpu_done ? ", ended by the firmware" : "");
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        const struct transcript *t = &bench->bus[i].transcript;
        fprintf(out,
                "bus %u:   %" PRIu32 " packets in, %" PRIu32 " out, %" PRIu32
                " damaged; wire busy %.1f %%\n",
                i, t->packets_in, t->packets_out, t->damaged, percent(t->busy, bench->end));
    }
    fprintf(out, "cpu:     %.1f %% in interrupt handlers, awake %.1f %%\n",
            percent(cpu->in_handlers, bench->end), 100.0 - percent(cpu->asleep, bench->end));
    if (bench->host.framing_errors) {
        fprintf(out, "host:    %" PRIu32 " bytes of the firmware with framing errors: baud rate?\n",
                bench->host.framing_errors);
    }
    rules_report(&bench->rules, out);
}

bool bench_free(struct bench *bench)
{
    bool good = vcd_close(&bench->vcd);
    good = motion_close(&bench->motion) && good;
    if (bench->transcript) {
        good = fclose(bench->transcript) == 0 && good;
    }
    for (unsigned i = 0; i < BOARD_BUSES_MAX; i++) {
        if (bench->bus[i].bench) {
            servos_free(&bench->bus[i].servos);
        }
    }
    pty_close(&bench->pty);
    machine_free(&bench->machine);
    script_free(&bench->script);
    schedule_free(&bench->schedule);
    return good;
}
