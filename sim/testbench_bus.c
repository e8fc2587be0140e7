#include "testbench_bus.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

#include "output/files.h"

/* How long a run in real time sleeps. While there is traffic, short enough for the client not to
 * wait for a reply. A client that writes, comes or leaves wakes the run, unless pty_fd() is -1. */
#define US         (BUS_CLOCK_HZ / 1000000)
#define TRAFFIC    (200 * US)
#define NO_TRAFFIC (5000 * US)
#define NO_CLIENT  (2000 * US)
#define TRAFFIC_IS (20000 * US) // an edge on the wire within this time

/* --- who tells whom ------------------------------------------------------------------------------
 */

static void byte_received(void *context, uint64_t now, uint8_t byte)
{
    struct bus *bus = context;
    (void)now;
    pty_send(&bus->pty, &byte, 1);
}

static void adapter_byte(void *context, uint64_t now)
{
    struct bus *bus = context;
    faults_controller_byte(&bus->faults, now, &bus->adapter.tx);
}

static void adapter_talks(void *context, uint64_t now, bool talking)
{
    struct bus *bus = context;
    bus_trace_controller(&bus->trace, now, talking);
}

static void servo_talks(void *context, uint64_t now, const struct servo_node *node)
{
    struct bus *bus = context;
    bus_trace_servo(&bus->trace, now, node);
}

static void line_seen(void *context, const struct transcript *transcript)
{
    struct bus *bus = context;
    if (!transcript->good) {
        plot_mark(&bus->plot, 0, PLOT_DAMAGED, transcript->start);
    }
    script_record_packet(&bus->script, transcript);
}

static void fault_acts(void *context, uint64_t from, uint64_t until, const char *what)
{
    struct bus *bus = context;
    (void)until;
    (void)what;
    plot_mark(&bus->plot, 0, PLOT_FAULT, from);
}

static void time_is_over(void *context, uint64_t now)
{
    struct bus *bus = context;
    (void)now;
    bus->stop = 1;
}

/* --- what a scenario does ------------------------------------------------------------------------
 */

static uint64_t script_send(void *context, uint64_t now, const uint8_t *bytes, size_t size)
{
    struct bus *bus = context;
    adapter_send(&bus->adapter, now, bytes, size);
    return adapter_end(&bus->adapter);
}

static void script_baud(void *context, uint32_t baud)
{
    struct bus *bus = context;
    adapter_baud(&bus->adapter, baud);
}

static struct servos *script_bus(void *context, unsigned index)
{
    struct bus *bus = context;
    return index == 0 ? &bus->servos : 0;
}

static bool put_servos(struct bus *bus, uint64_t now, const uint8_t *ids, unsigned count)
{
    servo_eeprom_save(&bus->state);
    servos_replace(&bus->servos, now, ids, count);
    bus_trace_new_servos(&bus->trace, now);
    motion_new_servos(&bus->motion, now);
    return servo_eeprom_load(&bus->state);
}

static void script_servos(void *context, uint64_t now, const uint8_t *ids, unsigned count)
{
    struct bus *bus = context;
    if (!put_servos(bus, now, ids, count)) {
        bus->stop = 1;
    }
}

static const char *script_fault(void *context, uint64_t now, const char *text)
{
    struct bus *bus = context;
    return fault_order_bus(text) == 0 ? faults_order(&bus->faults, now, text)
                                      : "there is no such bus";
}

static void script_echo(void *context, bool on)
{
    struct bus *bus = context;
    bus->transcript.echo = on ? stdout : 0;
}

static void script_outcome(void *context, uint64_t now, enum script_outcome outcome,
                           const char *what)
{
    struct bus *bus = context;
    if (outcome != SCRIPT_GOOD) {
        rules_break(&bus->rules, RULE_EXPECTATION, now, "%s:%u: %s", bus->options->script,
                    script_line_number(&bus->script), what);
    }
}

/* With a pty the scenario is the world around a client, who goes on. */
static void script_finished(void *context, uint64_t now)
{
    struct bus *bus = context;
    (void)now;
    bus->stop = !bus->options->pty;
}

/* --- set-up --------------------------------------------------------------------------------------
 */

static bool open_files(struct bus *bus)
{
    const struct bench_options *options = bus->options;
    if (options->transcript) {
        bus->transcript.file = fopen(options->transcript, "w");
        if (!bus->transcript.file) {
            fprintf(stderr, "%s: %s\n", options->transcript, strerror(errno));
            return false;
        }
    }
    if ((options->vcd && !vcd_open(&bus->vcd, options->vcd, BUS_CLOCK_HZ)) ||
        (options->plot && !plot_open(&bus->plot, options->plot, "servos on a bus", "adapter",
                                     &bus->schedule, BUS_CLOCK_HZ)) ||
        (options->csv &&
         !motion_open(&bus->motion, options->csv, &bus->schedule, &bus->servos, BUS_CLOCK_HZ))) {
        return false;
    }
    bus_trace_sig(&bus->trace, &bus->vcd, 0, &bus->sig);
    bus_trace_servos(&bus->trace, &bus->plot, &bus->servos);
    return true;
}

static void init_wire(struct bus *bus)
{
    struct schedule *schedule = &bus->schedule;
    net_init(&bus->sig);
    adapter_init(&bus->adapter, schedule, &bus->sig, &bus->sig, BUS_CLOCK_HZ, BUS_BAUD);
    bus->adapter.context = bus;
    bus->adapter.on_byte = byte_received;
    bus->adapter.on_start = adapter_byte;
    bus->adapter.on_talk = adapter_talks;
    transcript_init(&bus->transcript, schedule, &bus->sig, &bus->adapter.driver);
    bus->transcript.echo = bus->options->echo ? stdout : 0;
    bus->transcript.context = bus;
    bus->transcript.on_line = line_seen;
    servos_init(&bus->servos, schedule, &bus->sig, BUS_CLOCK_HZ);
    bus->servos.duplicates = bus->options->allow_duplicates;
    bus->servos.seed = bus->options->seed;
    faults_init(&bus->faults, schedule, &bus->servos, bus->options->seed);
    faults_connect_receiver(&bus->faults, &bus->adapter.rxd);
    bus->faults.context = bus;
    bus->faults.on_act = fault_acts;
    bus->servos.context = bus;
    bus->servos.on_talk = servo_talks;
}

static void init_time(struct bus *bus)
{
    const struct bench_options *options = bus->options;
    event_init(&bus->limit, time_is_over, bus);
    if (options->seconds > 0) {
        schedule_at(&bus->schedule, &bus->limit, (uint64_t)(options->seconds * BUS_CLOCK_HZ));
    }
    if (options->live_view) {
        live_view_init(&bus->live_view, stderr, &bus->schedule, BUS_CLOCK_HZ);
        live_view_add_bus(&bus->live_view, &bus->servos);
    }
}

static bool init_script(struct bus *bus)
{
    bus->ops = (struct script_ops){
        .context = bus,
        .send = script_send,
        .baud = script_baud,
        .bus = script_bus,
        .servos = script_servos,
        .fault = script_fault,
        .echo = script_echo,
        .rules = &bus->rules,
        .outcome = script_outcome,
        .finished = script_finished,
    };
    bus->script.echo = bus->options->echo;
    return !bus->options->script ||
           script_start(&bus->script, &bus->schedule, BUS_CLOCK_HZ, &bus->ops, stdout);
}

bool bus_init(struct bus *bus, const struct bench_options *options)
{
    *bus = (struct bus){.options = options, .pty = {.master = -1}};
    schedule_init(&bus->schedule);
    rules_init(&bus->rules, BUS_CLOCK_HZ, stdout);
    init_wire(bus);
    if ((options->script && !script_read(&bus->script, options->script)) || !open_files(bus)) {
        return false;
    }
    if (!servo_eeprom_init(&bus->state, options->state, 0, &bus->servos) ||
        !put_servos(bus, 0, options->servos[0].ids, options->servos[0].count) ||
        !bench_order_faults(options, script_fault, bus)) {
        return false;
    }
    if (options->pty) {
        if (!pty_open(&bus->pty, BUS_BAUD)) {
            return false;
        }
    }
    init_time(bus);
    return init_script(bus);
}

/* --- run and report ------------------------------------------------------------------------------
 */

/* What was said comes before the rate: a client sets the rate, then speaks. */
static void hear_client(struct bus *bus, uint64_t now)
{
    uint8_t bytes[PTY_BLOCK];
    size_t capacity = adapter_space(&bus->adapter);
    size_t size = pty_read(&bus->pty, bytes, capacity < sizeof(bytes) ? capacity : sizeof(bytes));
    adapter_baud(&bus->adapter, pty_baud(&bus->pty));
    adapter_send(&bus->adapter, now, bytes, size);
}

static void run_in_real_time(struct bus *bus)
{
    printf("%s\n", bus->pty.path); // a signal ends the run cleanly from here on
    fflush(stdout);
    realtime_start(&bus->realtime, BUS_CLOCK_HZ);
    while (!bus->stop) {
        uint64_t now = realtime_cycle(&bus->realtime);
        schedule_run_until(&bus->schedule, now);
        hear_client(bus, now);
        pty_flush(&bus->pty);
        bool traffic = bus->adapter.tx.busy || now - bus->sig.time < TRAFFIC_IS;
        int fd = adapter_space(&bus->adapter) ? pty_fd(&bus->pty) : -1;
        realtime_wait(&bus->realtime,
                      now + (traffic   ? TRAFFIC
                             : fd >= 0 ? NO_TRAFFIC
                                       : NO_CLIENT),
                      fd);
    }
}

bool bus_run(struct bus *bus)
{
    if (bus->options->pty) {
        run_in_real_time(bus);
    }
    while (!bus->stop && schedule_next(&bus->schedule) != SCHEDULE_NEVER) {
        schedule_run_until(&bus->schedule, schedule_next(&bus->schedule));
    }
    if (bus->options->script && !bus->script.done) {
        rules_break(&bus->rules, RULE_SCRIPT_UNFINISHED, bus->schedule.now, "%s:%u",
                    bus->options->script, script_line_number(&bus->script));
    }
    live_view_end(&bus->live_view, bus->schedule.now);
    transcript_end(&bus->transcript);
    servo_eeprom_save(&bus->state);
    return rules_broken(&bus->rules) == 0;
}

void bus_report(const struct bus *bus, FILE *out)
{
    const struct transcript *t = &bus->transcript;
    uint64_t end = bus->schedule.now;
    fprintf(out, "time:    %.6f s simulated\n", (double)end / BUS_CLOCK_HZ);
    fprintf(out,
            "bus 0:   %" PRIu32 " packets in, %" PRIu32 " out, %" PRIu32
            " damaged; wire busy %.1f %%\n",
            t->packets_in, t->packets_out, t->damaged,
            end ? 100.0 * (double)t->busy / (double)end : 0.0);
    faults_report(&bus->faults, "", out);
    if (bus->adapter.framing_errors) {
        fprintf(out, "adapter: %" PRIu32 " bytes with framing errors: baud rate?\n",
                bus->adapter.framing_errors);
    }
    pty_report(&bus->pty, out);
    if (bus->realtime.lost_ns) {
        fprintf(out, "pace:    %.3f s behind real time\n", (double)bus->realtime.lost_ns * 1e-9);
    }
    rules_report(&bus->rules, out);
}

bool bus_free(struct bus *bus)
{
    uint64_t end = bus->schedule.now;
    bool good = !end || plot_draw(&bus->plot, end);
    good = vcd_close(&bus->vcd) && good;
    good = motion_close(&bus->motion) && good;
    good = files_close(bus->transcript.file, bus->options->transcript) && good;
    plot_free(&bus->plot);
    servos_free(&bus->servos);
    pty_close(&bus->pty);
    script_free(&bus->script);
    schedule_free(&bus->schedule);
    return good && !bus->state.failed;
}
