/* SPDX-License-Identifier: MIT */
#include "testbench.h"

#include <inttypes.h>
#include <string.h>

#include "output/files.h"

/* --- callbacks of the parts --- */

static void circuit_changed(void *context, uint64_t now)
{
    struct testbench_bus *bus = context;
    bus_trace_circuit(&bus->trace, now);
    cycle_log_circuit(&bus->bench->cycle_log, now, bus->index, &bus->circuit);
}

static void controller_byte(void *context, uint64_t now)
{
    struct testbench_bus *bus = context;
    faults_controller_byte(&bus->faults, now, &bus->circuit.usart.tx);
    cycle_log_byte(&bus->bench->cycle_log, now, bus->index, &bus->circuit);
}

static void adapter_byte(void *context, uint64_t now)
{
    struct testbench_bus *bus = context;
    faults_controller_byte(&bus->faults, now, &bus->adapter.tx);
}

static void adapter_drives(void *context, uint64_t now, bool driving)
{
    struct testbench_bus *bus = context;
    bus_trace_controller(&bus->trace, now, driving);
}

static void adapter_received(void *context, uint64_t now, uint8_t byte)
{
    struct testbench_bus *bus = context;
    (void)now;
    testbench_send_to_client(bus->bench, byte);
}

static void servo_byte(void *context, uint64_t now, const struct servo_node *node)
{
    struct testbench_bus *bus = context;
    if (!node->driver.exempt) {
        bus_circuit_servo_byte(&bus->circuit, now, uart_tx_end(&node->tx));
    }
}

static void servo_drives(void *context, uint64_t now, const struct servo_node *node)
{
    struct testbench_bus *bus = context;
    bus_trace_servo(&bus->trace, now, node);
}

static void rule_broken(void *context, enum rule rule, uint64_t now)
{
    struct testbench_bus *bus = context;
    bool collision = rule == RULE_COLLISION || rule == RULE_TWO_DRIVERS;
    plot_mark(&bus->bench->plot, bus->index, collision ? PLOT_COLLISION : PLOT_BREACH, now);
}

static void fault_acts(void *context, uint64_t from, uint64_t until, const char *what)
{
    struct testbench_bus *bus = context;
    (void)until;
    (void)what;
    plot_mark(&bus->bench->plot, bus->index, PLOT_FAULT, from);
}

static void note_pause(struct testbench_bus *bus, uint64_t start)
{
    uint64_t pause = bus->latest_packet ? start - bus->latest_packet : 0;
    bus->longest_pause = pause > bus->longest_pause ? pause : bus->longest_pause;
    bus->latest_packet = start;
}

static void note_absent(struct testbench_bus *bus, const struct transcript *transcript)
{
    uint8_t id = transcript->bytes[2]; // behind the two bytes of the header
    if (transcript->good && id < IDS_MAX && !servos_have(&bus->servos, id)) {
        bus->unheard[id]++;
    }
}

static void line_recorded(void *context, const struct transcript *transcript)
{
    struct testbench_bus *bus = context;
    if (transcript->packet_from_controller) {
        note_pause(bus, transcript->start);
        note_absent(bus, transcript);
    }
    if (!transcript->good) {
        plot_mark(&bus->bench->plot, bus->index, PLOT_DAMAGED, transcript->start);
    }
    script_record_packet(&bus->bench->script, transcript);
}

static void handler_changed(void *context, uint64_t now, uint8_t vector)
{
    struct testbench *bench = context;
    vcd_change(&bench->vcd, bench->handler_signal, now, vector);
    cycle_log_handler(&bench->cycle_log, now);
}

static void was_reset(void *context, uint64_t now)
{
    struct testbench *bench = context;
    testbench_end_host_line(bench);
    for (unsigned i = 0; i < bench->bus_count; i++) {
        faults_controller_reset(&bench->bus[i].faults, now);
        bus_circuit_reset(&bench->bus[i].circuit, now);
    }
    if (bench->board.has_host) {
        usart_reset(&bench->host_link.usart, now);
    }
    if (bench->options->host == TESTBENCH_HOST_SCRIPT) {
        if (bench->script.echo) {
            printf("%10" PRIu64 " reset\n", now);
        }
        script_was_reset(&bench->script, now);
    }
}

/* While packets are printed, prints text of the firmware when its line ends, or has filled the
 * buffer: so no packet stands in a line. */
static void print_host_byte(struct testbench *bench, uint8_t byte)
{
    struct testbench_line *line = &bench->host_line;
    if (!bench->bus[0].transcript.echo) {
        fputc(byte, stdout);
        bench->rules.line_is_open = byte != '\n';
        return;
    }
    line->bytes[line->size++] = byte;
    if (byte == '\n' || line->size == sizeof(line->bytes)) {
        testbench_end_host_line(bench);
    }
}

void testbench_end_host_line(struct testbench *bench)
{
    struct testbench_line *line = &bench->host_line;
    if (line->size) {
        fwrite(line->bytes, 1, line->size, stdout);
        if (line->bytes[line->size - 1] != '\n') {
            fputc('\n', stdout);
        }
    }
    line->size = 0;
}

static void console_byte(void *context, uint64_t now, uint8_t byte)
{
    struct testbench *bench = context;
    switch (bench->options->host) {
    case TESTBENCH_HOST_SCRIPT:
        script_receive(&bench->script, now, byte);
        if (bench->options->prints_text && !bench->script.echo) {
            print_host_byte(bench, byte);
        }
        break;
    case TESTBENCH_HOST_PTY:
    case TESTBENCH_HOST_TCP:
        bench->traffic = now;
        testbench_send_to_client(bench, byte);
        if (bench->options->poke) {
            script_receive(&bench->script, now, byte);
        }
        break;
    case TESTBENCH_HOST_STDOUT: print_host_byte(bench, byte); break;
    case TESTBENCH_HOST_PC: pc_program_receive(&bench->pc_program, now, byte); break;
    case TESTBENCH_HOST_NONE: break;
    }
}

static void pc_program_ended(void *context, uint64_t now, const char *wrong)
{
    struct testbench *bench = context;
    if (wrong) {
        rules_record_breach(&bench->rules, RULE_EXPECTATION, now, "%s:%u: %s", bench->options->pc,
                            pc_program_line_number(&bench->pc_program), wrong);
    }
    testbench_stop(bench);
}

static void time_is_over(void *context, uint64_t now)
{
    (void)now;
    testbench_stop(context);
}

/* --- set-up: instruments --- */

static bool open_transcript(struct testbench *bench)
{
    const char *path = bench->options->transcript;
    if (!path) {
        return true;
    }
    bench->transcript = files_create(path);
    return bench->transcript != 0;
}

static bool open_plot(struct testbench *bench)
{
    const struct testbench_options *options = bench->options;
    if (options->bus) {
        return plot_open(&bench->plot, options->plot, "servos on a bus", "adapter", options->panes,
                         &bench->schedule, bench->clock_Hz);
    }
    const char *slash = strrchr(options->elf, '/');
    snprintf(bench->title, sizeof(bench->title), "%s on %s", slash ? slash + 1 : options->elf,
             options->board);
    return plot_open(&bench->plot, options->plot, bench->title, "controller", options->panes,
                     &bench->schedule, bench->clock_Hz);
}

static bool open_gdb(struct testbench *bench)
{
    struct machine *machine = &bench->machine;
    if (!gdb_open(&bench->gdb, bench->options->gdb_port)) {
        return false;
    }
    gdb_attach(&bench->gdb, machine->avr, &machine->cpu, &machine->eeprom, &machine->stop);
    machine->gdb = &bench->gdb;
    return true;
}

static bool open_instruments(struct testbench *bench)
{
    const struct testbench_options *options = bench->options;
    uint32_t clock_Hz = bench->clock_Hz;
    if (!open_transcript(bench) ||
        (options->vcd && !vcd_open(&bench->vcd, options->vcd, clock_Hz)) ||
        (options->csv && !motion_open(&bench->motion, options->csv, &bench->schedule,
                                      &bench->bus[0].servos, clock_Hz)) ||
        (!options->bus && !cycle_log_open(&bench->cycle_log, &bench->machine, &options->cycles)) ||
        (options->plot && !open_plot(bench)) || (options->gdb && !open_gdb(bench)) ||
        (options->eeprom && !eeprom_model_load(&bench->machine.eeprom, options->eeprom))) {
        return false;
    }
    if (options->follow) {
        live_view_init(&bench->live_view, stderr, &bench->schedule, clock_Hz,
                       &bench->rules.line_is_open);
    }
    if (!options->bus) {
        bench->handler_signal = vcd_signal(&bench->vcd, "cpu_handler_vector", 8);
        bench->machine.cpu.context = bench;
        bench->machine.cpu.on_handler = handler_changed;
    }
    return true;
}

/* --- set-up: buses --- */

static void init_rules(struct testbench_bus *bus)
{
    if (bus->bench->bus_count > 1) {
        snprintf(bus->label, sizeof(bus->label), " bus%u", bus->index);
        snprintf(bus->where, sizeof(bus->where), "bus %u: ", bus->index);
    }
    rules_init_bus(&bus->rules, &bus->bench->rules, bus->where);
    bus->rules.context = bus;
    bus->rules.on_breach = rule_broken;
}

/* Returns false, with one line on stderr, if the chip lacks what the board uses. */
static bool init_circuit(struct testbench_bus *bus)
{
    struct testbench *bench = bus->bench;
    bus->wire = &bus->circuit.sig;
    if (!bus_circuit_init(&bus->circuit, &bench->machine, &bench->board.bus[bus->index],
                          bench->options->exact, &bus->rules)) {
        return false;
    }
    transcript_init(&bus->transcript, &bench->schedule, bus->wire, &bus->circuit.to_sig);
    bus->transcript.controller_tx = &bus->circuit.usart.txd;
    bus_trace_init(&bus->trace, &bench->vcd, bus->index, &bus->circuit);
    bus->circuit.context = bus;
    bus->circuit.on_change = circuit_changed;
    bus->circuit.on_byte = controller_byte;
    return true;
}

static void init_adapter(struct testbench_bus *bus)
{
    struct testbench *bench = bus->bench;
    bus->wire = &bus->adapter_wire;
    net_init(bus->wire);
    adapter_init(&bus->adapter, &bench->schedule, bus->wire, bus->wire, bench->clock_Hz,
                 TESTBENCH_BAUD);
    bus->adapter.context = bus;
    bus->adapter.on_byte = adapter_received;
    bus->adapter.on_start = adapter_byte;
    bus->adapter.on_drive = adapter_drives;
    transcript_init(&bus->transcript, &bench->schedule, bus->wire, &bus->adapter.driver);
    bus_trace_sig(&bus->trace, &bench->vcd, bus->index, bus->wire);
}

static void init_servos(struct testbench_bus *bus)
{
    struct testbench *bench = bus->bench;
    const struct testbench_options *options = bench->options;
    servos_init(&bus->servos, &bench->schedule, bus->wire, bench->clock_Hz);
    bus->servos.context = bus;
    bus->servos.on_byte = options->bus ? 0 : servo_byte;
    bus->servos.on_drive = servo_drives;
    bus->servos.seed = options->seed + bus->index * 0x10001u;
    bus->servos.duplicates = options->allow_duplicates;
    faults_init(&bus->faults, &bench->schedule, &bus->servos, bus->servos.seed);
    faults_connect_receiver(&bus->faults, options->bus ? &bus->adapter.rxd : &bus->circuit.rxd);
    bus->faults.context = bus;
    bus->faults.on_act = fault_acts;
}

static bool init_bus(struct testbench *bench, unsigned index)
{
    struct testbench_bus *bus = &bench->bus[index];
    bus->bench = bench;
    bus->index = index;
    init_rules(bus);
    if (bench->options->bus) {
        init_adapter(bus);
    } else if (!init_circuit(bus)) {
        return false;
    }
    bus->transcript.label = bus->label;
    bus->transcript.file = bench->transcript;
    bus->transcript.context = bus;
    bus->transcript.on_line = line_recorded;
    init_servos(bus);
    bus_trace_servos(&bus->trace, &bench->plot, &bus->servos);
    if (index > 0) {
        motion_bus(&bench->motion, &bus->servos);
    }
    if (bench->options->follow) {
        live_view_add_bus(&bench->live_view, &bus->servos);
    }
    return servo_eeprom_init(&bus->eeprom, bench->options->state, index, &bus->servos);
}

static bool init_buses(struct testbench *bench)
{
    for (unsigned i = 0; i < bench->bus_count; i++) {
        if (!init_bus(bench, i)) {
            return false;
        }
    }
    return true;
}

bool testbench_put_servos(struct testbench_bus *bus, uint64_t now, const uint8_t *ids,
                          unsigned count)
{
    servo_eeprom_save(&bus->eeprom);
    servos_replace(&bus->servos, now, ids, count);
    bus_trace_new_servos(&bus->trace, now);
    return servo_eeprom_load(&bus->eeprom);
}

/* Puts the servos of the command line on their buses. */
static bool put_first_servos(struct testbench *bench)
{
    for (unsigned i = 0; i < BOARD_BUSES_MAX; i++) {
        const struct testbench_servos *servos = &bench->options->servos[i];
        if (i >= bench->bus_count && servos->count) {
            fprintf(stderr, "--servos %u:...: %s has %u bus%s, counted from 0\n", i,
                    bench->options->board, bench->bus_count, bench->bus_count == 1 ? "" : "es");
            return false;
        }
        if (i < bench->bus_count &&
            !testbench_put_servos(&bench->bus[i], 0, servos->ids, servos->count)) {
            return false;
        }
    }
    motion_new_servos(&bench->motion, 0);
    return true;
}

static bool inject_first_faults(struct testbench *bench)
{
    const struct testbench_options *options = bench->options;
    for (unsigned i = 0; i < options->fault_count; i++) {
        const char *wrong = testbench_fault(bench, 0, options->faults[i]);
        if (wrong) {
            fprintf(stderr, "--fault \"%s\": %s\n", options->faults[i], wrong);
            return false;
        }
    }
    return true;
}

/* --- set-up: controller and host --- */

static bool init_controller(struct testbench *bench)
{
    const struct testbench_options *options = bench->options;
    if (!board_read(&bench->board, options->boards, options->board)) {
        return false;
    }
    bench->clock_Hz = bench->board.clock_Hz;
    bench->bus_count = bench->board.bus_count;
    return machine_init(&bench->machine, &bench->schedule, bench->board.mcu, bench->board.core,
                        bench->clock_Hz, options->elf, options->exact);
}

static bool init_host_link(struct testbench *bench)
{
    const struct testbench_options *options = bench->options;
    if (bench->board.has_host) {
        if (!host_link_init(&bench->host_link, &bench->machine, bench->board.host_usart,
                            bench->board.host_baud, options->exact)) {
            return false;
        }
        bench->host_link.adapter.context = bench;
        bench->host_link.adapter.on_byte = console_byte;
    } else if (options->host != TESTBENCH_HOST_NONE && options->host != TESTBENCH_HOST_SCRIPT) {
        fprintf(
            stderr,
            "%s: the board has no host link, so it has no console: run a program of the library "
            "instead, as in: make run-example EXAMPLE=two_joints BOARD=arduino-uno; or give "
            "--seconds in place of --host\n",
            options->board);
        return false;
    }
    return true;
}

static void start_pc_program(struct testbench *bench)
{
    bench->pc_program.context = bench;
    bench->pc_program.on_reset = testbench_reset;
    bench->pc_program.on_end = pc_program_ended;
    pc_program_start(&bench->pc_program, &bench->schedule, bench->clock_Hz, &bench->host_link,
                     stdout);
}

static bool start_host(struct testbench *bench)
{
    const struct testbench_options *options = bench->options;
    if (!options->bus && !init_host_link(bench)) {
        return false;
    }
    bool client =
        options->pty || options->host == TESTBENCH_HOST_PTY || options->host == TESTBENCH_HOST_TCP;
    if (client && !testbench_open_client(bench)) {
        return false;
    }
    if (options->poke && !testbench_open_poke(bench)) {
        bench->cannot_listen = true;
        return false;
    }
    if (options->host == TESTBENCH_HOST_PC) {
        start_pc_program(bench);
    }
    return options->host != TESTBENCH_HOST_SCRIPT || testbench_start_script(bench);
}

static void set_time_limit(struct testbench *bench)
{
    event_init(&bench->time_limit, time_is_over, bench);
    if (bench->options->seconds > 0) {
        double cycles = bench->options->seconds * bench->clock_Hz;
        schedule_at(&bench->schedule, &bench->time_limit, (uint64_t)cycles);
    }
}

bool testbench_init(struct testbench *bench, const struct testbench_options *options)
{
    *bench = (struct testbench){.options = options,
                                .clock_Hz = TESTBENCH_CLOCK_HZ,
                                .bus_count = 1,
                                .pty = {.master = -1},
                                .tcp = {.listener = -1, .client = -1},
                                .poke = {.socket = {.listener = -1, .client = -1}},
                                .gdb = {.listener = -1, .client = -1}};
    schedule_init(&bench->schedule);
    if ((options->script && !script_read(&bench->script, options->script)) ||
        (options->pc && !pc_program_read(&bench->pc_program, options->pc)) ||
        (!options->bus && !init_controller(bench))) {
        return false;
    }
    rules_init(&bench->rules, bench->clock_Hz, stdout);
    bench->rules.warn = options->rules_warn;
    if (!open_instruments(bench) || !init_buses(bench)) {
        return false;
    }
    if (!options->bus) {
        bench->machine.context = bench;
        bench->machine.on_reset = was_reset;
        reset_injection_init(&bench->reset, &bench->machine);
    }
    if (!put_first_servos(bench) || !inject_first_faults(bench)) {
        return false;
    }
    testbench_echo(bench, options->echo);
    set_time_limit(bench);
    return start_host(bench);
}
