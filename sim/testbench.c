#include "testbench.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

#include "output/files.h"

/* Steps of a run in real time: while there is traffic, short ones, so that replies do not wait. */
#define STEPS_PER_MS 5
#define TRAFFIC_MS   20 // a byte of the client or for it within this time

/* --- who tells whom ------------------------------------------------------------------------------
 */

static void wire_changed(void *context, uint64_t now)
{
    struct bench_bus *bus = context;
    bus_trace_circuit(&bus->trace, now);
    times_wire(&bus->bench->times, now, bus->index, &bus->circuit);
}

static void servo_byte(void *context, uint64_t now, const struct servo_node *node)
{
    struct bench_bus *bus = context;
    if (!node->driver.exempt) {
        bus_circuit_servo_byte(&bus->circuit, now, uart_tx_end(&node->tx));
    }
}

static void controller_byte(void *context, uint64_t now)
{
    struct bench_bus *bus = context;
    faults_controller_byte(&bus->faults, now, &bus->circuit.usart.tx);
    times_byte(&bus->bench->times, now, bus->index, &bus->circuit);
}

static void servo_talks(void *context, uint64_t now, const struct servo_node *node)
{
    struct bench_bus *bus = context;
    bus_trace_servo(&bus->trace, now, node);
}

/* Two talked, or a rule of the wire was broken in another way. */
static void rule_broken(void *context, enum rule rule, uint64_t now)
{
    struct bench_bus *bus = context;
    bool collision = rule == RULE_COLLISION || rule == RULE_TWO_DRIVERS;
    plot_mark(&bus->bench->plot, bus->index, collision ? PLOT_COLLISION : PLOT_BREACH, now);
}

static void fault_acts(void *context, uint64_t from, uint64_t until, const char *what)
{
    struct bench_bus *bus = context;
    (void)until;
    (void)what;
    plot_mark(&bus->bench->plot, bus->index, PLOT_FAULT, from);
}

static void line_seen(void *context, const struct transcript *transcript)
{
    struct bench_bus *bus = context;
    if (!transcript->good) {
        plot_mark(&bus->bench->plot, bus->index, PLOT_DAMAGED, transcript->start);
    }
    script_record_packet(&bus->bench->script, transcript);
}

static void handler_runs(void *context, uint64_t now, uint8_t vector)
{
    struct bench *bench = context;
    vcd_change(&bench->vcd, bench->handler, now, vector);
    times_handler(&bench->times, now);
}

static void was_reset(void *context, uint64_t now)
{
    struct bench *bench = context;
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        faults_controller_reset(&bench->bus[i].faults, now);
        bus_circuit_reset(&bench->bus[i].circuit, now);
    }
    if (bench->board.has_host) {
        usart_reset(&bench->host_link.usart, now);
    }
    if (bench->options->host == BENCH_HOST_SCRIPT) {
        if (bench->script.echo) {
            printf("%10" PRIu64 " reset\n", now);
        }
        script_was_reset(&bench->script, now);
    }
}

static void host_byte(void *context, uint64_t now, uint8_t byte)
{
    struct bench *bench = context;
    switch (bench->options->host) {
    case BENCH_HOST_SCRIPT: script_receive(&bench->script, now, byte); break;
    case BENCH_HOST_PTY:
        bench->traffic = now;
        pty_send(&bench->pty, &byte, 1);
        break;
    case BENCH_HOST_STDOUT: fputc(byte, stdout); break;
    case BENCH_HOST_PC: pc_program_receive(&bench->pc_program, now, byte); break;
    case BENCH_HOST_NONE: break;
    }
}

/* A client may be there before the firmware listens: its bytes wait. */
static size_t pty_room(const struct bench *bench)
{
    return usart_rxen(&bench->host_link.usart) ? host_link_space(&bench->host_link) : 0;
}

static void hear_client(struct bench *bench, uint64_t now)
{
    uint8_t bytes[PTY_BLOCK];
    size_t capacity = pty_room(bench);
    size_t size = pty_read(&bench->pty, bytes, capacity < sizeof(bytes) ? capacity : sizeof(bytes));
    if (bench->options->client_baud) {
        adapter_baud(&bench->host_link.adapter,
                     pty_baud(&bench->pty)); // for these, and what is heard
    }
    adapter_send(&bench->host_link.adapter, now, bytes, size);
    bench->traffic = size ? now : bench->traffic;
}

/* With a pty: the simulation follows real time. It sleeps until the client writes or a step of real
 * time has passed, then simulates as much time as that was. So what the client writes is read at
 * once, and reaches the firmware at the cycle at which it was read. A run that is late simulates a
 * whole step without a sleep. */
static void keep_pace(void *context, uint64_t now)
{
    struct bench *bench = context;
    uint32_t ms = bench->board.clock_Hz / 1000;
    hear_client(bench, now);
    pty_flush(&bench->pty);
    bool traffic = now - bench->traffic < TRAFFIC_MS * ms;
    uint64_t step = now + (traffic ? ms / STEPS_PER_MS : ms);
    realtime_wait(&bench->realtime, step, pty_room(bench) ? pty_fd(&bench->pty) : -1);
    uint64_t next = realtime_cycle(&bench->realtime);
    next = next > now ? next : now + 1;
    schedule_at(&bench->schedule, &bench->keep_pace, next < step ? next : step);
}

static void time_is_over(void *context, uint64_t now)
{
    struct bench *bench = context;
    (void)now;
    machine_stop(&bench->machine);
}

/* --- what a script does --------------------------------------------------------------------------
 */

static bool script_ready(void *context)
{
    struct bench *bench = context;
    return bench->board.has_host && usart_rxen(&bench->host_link.usart);
}

static void script_say(void *context, uint64_t now, const char *bytes, size_t size)
{
    struct bench *bench = context;
    host_link_send(&bench->host_link, now, bytes, size);
}

static bool put_servos(struct bench_bus *bus, uint64_t now, const uint8_t *ids, unsigned count)
{
    servo_eeprom_save(&bus->state);
    servos_replace(&bus->servos, now, ids, count);
    bus_trace_new_servos(&bus->trace, now);
    return servo_eeprom_load(&bus->state);
}

static void script_servos(void *context, uint64_t now, const uint8_t *ids, unsigned count)
{
    struct bench *bench = context;
    if (!put_servos(&bench->bus[0], now, ids, count)) {
        machine_stop(&bench->machine);
    }
    motion_new_servos(&bench->motion, now);
}

static struct servos *script_bus(void *context, unsigned index)
{
    struct bench *bench = context;
    return index < bench->board.bus_count ? &bench->bus[index].servos : 0;
}

static const char *script_fault(void *context, uint64_t now, const char *text)
{
    struct bench *bench = context;
    unsigned bus = fault_order_bus(text);
    return bus < bench->board.bus_count ? faults_order(&bench->bus[bus].faults, now, text)
                                        : "the board has no such bus";
}

static void order_reset(void *context, uint64_t now, const struct reset_order *order)
{
    struct bench *bench = context;
    reset_injection_order(&bench->reset, now, order);
}

static void script_echo(void *context, bool on)
{
    struct bench *bench = context;
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        bench->bus[i].transcript.echo = on ? stdout : 0;
    }
}

static void script_outcome(void *context, uint64_t now, enum script_outcome outcome,
                           const char *what)
{
    static const enum rule rule[] = {
        [SCRIPT_UNEXPECTED_ERROR] = RULE_REPLY_WAS_ERROR,
        [SCRIPT_UNEXPECTED_OK] = RULE_REPLY_WAS_OK,
        [SCRIPT_SILENCE] = RULE_SCRIPT_UNFINISHED,
        [SCRIPT_UNMET] = RULE_EXPECTATION,
    };
    struct bench *bench = context;
    if (outcome != SCRIPT_GOOD) {
        rules_break(&bench->rules, rule[outcome], now, "%s:%u: %s%s", bench->options->script,
                    script_line_number(&bench->script), what,
                    outcome == SCRIPT_SILENCE ? ": no reply" : "");
    }
}

static void script_finished(void *context, uint64_t now)
{
    struct bench *bench = context;
    (void)now;
    machine_stop(&bench->machine);
}

static void pc_ended(void *context, uint64_t now, const char *wrong)
{
    struct bench *bench = context;
    if (wrong) {
        rules_break(&bench->rules, RULE_EXPECTATION, now, "%s:%u: %s", bench->options->pc,
                    bench->pc_program.line[bench->pc_program.next - 1].number, wrong);
    }
    machine_stop(&bench->machine);
}

static const struct script_ops script_ops = {
    .ready = script_ready,
    .say = script_say,
    .bus = script_bus,
    .servos = script_servos,
    .fault = script_fault,
    .reset = order_reset,
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
    bus->index = index;
    if (bench->board.bus_count > 1) {
        snprintf(bus->label, sizeof(bus->label), " bus%u", index);
        snprintf(bus->where, sizeof(bus->where), "bus %u: ", index);
    }
    rules_init_bus(&bus->rules, &bench->rules, bus->where);
    bus->rules.context = bus;
    bus->rules.on_break = rule_broken;
    if (!bus_circuit_init(&bus->circuit, &bench->machine, &bench->board.bus[index],
                          bench->options->exact, &bus->rules)) {
        return false;
    }
    transcript_init(&bus->transcript, &bench->schedule, &bus->circuit.sig, &bus->circuit.to_sig);
    bus->transcript.controller_talker = &bus->circuit.usart.txd;
    bus->transcript.label = bus->label;
    bus->transcript.file = bench->transcript;
    bus->transcript.context = bus;
    bus->transcript.on_line = line_seen;
    servos_init(&bus->servos, &bench->schedule, &bus->circuit.sig, clock_Hz);
    bus_trace_init(&bus->trace, &bench->vcd, index, &bus->circuit);
    bus_trace_servos(&bus->trace, &bench->plot, &bus->servos);
    if (index > 0) {
        motion_bus(&bench->motion, &bus->servos);
    }
    bus->circuit.context = bus;
    bus->circuit.on_change = wire_changed;
    bus->circuit.on_byte = controller_byte;
    bus->servos.context = bus;
    bus->servos.on_byte = servo_byte;
    bus->servos.on_talk = servo_talks;
    bus->servos.seed = bench->options->seed + index * 0x10001u;
    bus->servos.duplicates = bench->options->allow_duplicates;
    faults_init(&bus->faults, &bench->schedule, &bus->servos, bus->servos.seed);
    faults_connect_receiver(&bus->faults, &bus->circuit.rxd);
    bus->faults.context = bus;
    bus->faults.on_act = fault_acts;
    if (bench->options->live_view) {
        live_view_add_bus(&bench->live_view, &bus->servos);
    }
    return servo_eeprom_init(&bus->state, bench->options->state, index, &bus->servos);
}

static bool open_pty(struct bench *bench)
{
    if (!pty_open(&bench->pty, bench->board.host_baud)) {
        return false;
    }
    realtime_start(&bench->realtime, bench->board.clock_Hz);
    event_init(&bench->keep_pace, keep_pace, bench);
    schedule_at(&bench->schedule, &bench->keep_pace, 0);
    return true;
}

static bool start_script(struct bench *bench)
{
    bench->ops = script_ops;
    bench->ops.context = bench;
    bench->ops.rules = &bench->rules;
    if (!bench->board.has_host) {
        bench->ops.say = 0;
    }
    bench->script.echo = bench->options->echo;
    return script_start(&bench->script, &bench->schedule, bench->board.clock_Hz, &bench->ops,
                        stdout);
}

static bool init_host(struct bench *bench)
{
    const struct bench_options *options = bench->options;
    if (bench->board.has_host) {
        if (!host_link_init(&bench->host_link, &bench->machine, bench->board.host_usart,
                            bench->board.host_baud, options->exact)) {
            return false;
        }
        bench->host_link.adapter.context = bench;
        bench->host_link.adapter.on_byte = host_byte;
    } else if (options->host == BENCH_HOST_PTY || options->host == BENCH_HOST_STDOUT ||
               options->host == BENCH_HOST_PC) {
        fprintf(stderr, "%s: the board has no host link: no --host\n", options->board);
        return false;
    }
    switch (options->host) {
    case BENCH_HOST_SCRIPT: return start_script(bench);
    case BENCH_HOST_PTY: return open_pty(bench);
    case BENCH_HOST_PC:
        bench->pc_program.context = bench;
        bench->pc_program.on_reset = order_reset;
        bench->pc_program.on_end = pc_ended;
        pc_program_start(&bench->pc_program, &bench->schedule, bench->board.clock_Hz,
                         &bench->host_link, stdout);
        return true;
    default: return true;
    }
}

static bool open_plot(struct bench *bench)
{
    const struct bench_options *options = bench->options;
    const char *slash = strrchr(options->elf, '/');
    snprintf(bench->title, sizeof(bench->title), "%s on %s", slash ? slash + 1 : options->elf,
             options->board);
    return plot_open(&bench->plot, options->plot, bench->title, "controller", &bench->schedule,
                     bench->board.clock_Hz);
}

static bool open_gdb(struct bench *bench)
{
    struct machine *machine = &bench->machine;
    if (!gdb_open(&bench->gdb, bench->options->gdb_port)) {
        return false;
    }
    gdb_attach(&bench->gdb, machine->avr, &machine->cpu, &machine->eeprom, &machine->stop);
    machine->gdb = &bench->gdb;
    return true;
}

static bool init_instruments(struct bench *bench)
{
    const struct bench_options *options = bench->options;
    uint32_t clock_Hz = bench->board.clock_Hz;
    if (!open_transcript(bench) ||
        (options->vcd && !vcd_open(&bench->vcd, options->vcd, clock_Hz)) ||
        (options->csv && !motion_open(&bench->motion, options->csv, &bench->schedule,
                                      &bench->bus[0].servos, clock_Hz)) ||
        (options->mark && !mark_open(&bench->mark, &bench->machine.cpu, options->mark)) ||
        (options->times && !times_open(&bench->times, &bench->machine, options->times)) ||
        (options->stamp && !times_stamp(&bench->times, options->stamp)) ||
        (options->steps && !times_steps(&bench->times, options->steps)) ||
        (options->plot && !open_plot(bench)) || (options->gdb && !open_gdb(bench)) ||
        (options->eeprom && !eeprom_model_load(&bench->machine.eeprom, options->eeprom))) {
        return false;
    }
    bench->handler = vcd_signal(&bench->vcd, "cpu_handler_vector", 8);
    bench->machine.cpu.context = bench;
    bench->machine.cpu.on_handler = handler_runs;
    return true;
}

/* Those of the command line. */
static bool init_servos(struct bench *bench)
{
    for (unsigned i = 0; i < BOARD_BUSES_MAX; i++) {
        const struct bench_servos *servos = &bench->options->servos[i];
        if (i >= bench->board.bus_count && servos->count) {
            fprintf(stderr, "--servos %u:...: %s has %u bus%s, counted from 0\n", i,
                    bench->options->board, bench->board.bus_count,
                    bench->board.bus_count == 1 ? "" : "es");
            return false;
        }
        if (i < bench->board.bus_count &&
            !put_servos(&bench->bus[i], 0, servos->ids, servos->count)) {
            return false;
        }
    }
    motion_new_servos(&bench->motion, 0);
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

bool bench_order_faults(const struct bench_options *options,
                        const char *(*order)(void *context, uint64_t now, const char *text),
                        void *context)
{
    for (unsigned i = 0; i < options->fault_count; i++) {
        const char *wrong = order(context, 0, options->faults[i]);
        if (wrong) {
            fprintf(stderr, "--fault \"%s\": %s\n", options->faults[i], wrong);
            return false;
        }
    }
    return true;
}

bool bench_init(struct bench *bench, const struct bench_options *options)
{
    *bench = (struct bench){
        .options = options, .pty = {.master = -1}, .gdb = {.listener = -1, .client = -1}};
    schedule_init(&bench->schedule);
    if ((options->script && !script_read(&bench->script, options->script)) ||
        (options->pc && !pc_program_read(&bench->pc_program, options->pc))) {
        return false;
    }
    if (!board_read(&bench->board, options->boards, options->board)) {
        return false;
    }
    rules_init(&bench->rules, bench->board.clock_Hz, stdout);
    bench->rules.warn = options->rules_warn;
    if (!machine_init(&bench->machine, &bench->schedule, bench->board.mcu, bench->board.core,
                      bench->board.clock_Hz, options->elf, options->exact) ||
        !init_instruments(bench)) {
        return false;
    }
    if (options->live_view) {
        live_view_init(&bench->live_view, stderr, &bench->schedule, bench->board.clock_Hz);
    }
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        if (!init_bus(bench, i)) {
            return false;
        }
    }
    bench->machine.context = bench;
    bench->machine.on_reset = was_reset;
    reset_injection_init(&bench->reset, &bench->machine);
    if (!init_servos(bench) || !bench_order_faults(options, script_fault, bench)) {
        return false;
    }
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

/* A signal ends the run cleanly from here on. */
static void tell_pty(const struct bench *bench)
{
    const char *path = bench->pty.path;
    printf("%s\nopen it with: picocom -q --echo %s (apt-get install picocom; or tio, screen); "
           "Ctrl-C here ends the run\n",
           path, path);
    fflush(stdout);
}

bool bench_run(struct bench *bench)
{
    if (bench->options->host == BENCH_HOST_PTY) {
        tell_pty(bench);
    }
    bench->ran = true;
    enum machine_end end = machine_run(&bench->machine);
    bench->end = bench->machine.avr->cycle;
    bench->cpu_done = end == MACHINE_DONE;
    if (end == MACHINE_CRASHED) {
        rules_break(&bench->rules, RULE_CRASH, bench->end, "%s", bench->machine.crash);
    }
    if (bench->options->script && !bench->script.done && end != MACHINE_CRASHED) {
        rules_break(&bench->rules, RULE_SCRIPT_UNFINISHED, bench->end, "%s:%u: %s",
                    bench->options->script, script_line_number(&bench->script),
                    why_unfinished(bench));
    }
    live_view_end(&bench->live_view, bench->end);
    pty_flush(&bench->pty);
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        transcript_end(&bench->bus[i].transcript);
        servo_eeprom_save(&bench->bus[i].state);
    }
    return !rules_failed(&bench->rules);
}

static double percent(uint64_t part, uint64_t whole)
{
    return whole ? 100.0 * (double)part / (double)whole : 0.0;
}

void bench_report(struct bench *bench, FILE *out)
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
    for (unsigned i = 0; i < bench->board.bus_count; i++) {
        faults_report(&bench->bus[i].faults, bench->bus[i].where, out);
    }
    fprintf(out, "cpu:     %.1f %% in interrupt handlers, awake %.1f %%\n",
            percent(cpu->in_handlers, bench->end), 100.0 - percent(cpu->asleep, bench->end));
    mark_report(&bench->mark, bench->end, out);
    if (bench->host_link.adapter.framing_errors) {
        fprintf(out, "host:    %" PRIu32 " bytes of the firmware with framing errors: baud rate?\n",
                bench->host_link.adapter.framing_errors);
    }
    pty_report(&bench->pty, out);
    if (bench->realtime.lost_ns) {
        fprintf(out, "pace:    %.3f s behind real time\n", (double)bench->realtime.lost_ns * 1e-9);
    }
    rules_report(&bench->rules, out);
}

static bool save_results(struct bench *bench)
{
    const char *eeprom = bench->options->eeprom;
    bool good = true;
    if (bench->ran) {
        good = plot_draw(&bench->plot, bench->end);
        if (eeprom) {
            eeprom_model_lose_power(&bench->machine.eeprom, bench->end);
            good = eeprom_model_save(&bench->machine.eeprom, eeprom) && good;
        }
    }
    return good;
}

bool bench_free(struct bench *bench)
{
    bool good = save_results(bench);
    good = vcd_close(&bench->vcd) && good;
    good = motion_close(&bench->motion) && good;
    good = times_close(&bench->times, bench->end) && good;
    good = files_close(bench->transcript, bench->options->transcript) && good;
    for (unsigned i = 0; i < BOARD_BUSES_MAX; i++) {
        if (bench->bus[i].bench) {
            good = good && !bench->bus[i].state.failed;
            servos_free(&bench->bus[i].servos);
        }
    }
    plot_free(&bench->plot);
    gdb_close(&bench->gdb);
    pty_close(&bench->pty);
    machine_free(&bench->machine);
    script_free(&bench->script);
    pc_program_free(&bench->pc_program);
    schedule_free(&bench->schedule);
    return good;
}
