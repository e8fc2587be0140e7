/* SPDX-License-Identifier: MIT */
/* The testbench at work: the run, its report, and its end. testbench.c sets it up. */
#include "testbench.h"

#include <inttypes.h>
#include <string.h>

#include "output/files.h"

#define PAUSE_MS    8  // two periods of the cycle of a robot object
#define UNHEARD_MIN 20 // packets

/* --- run --- */

void testbench_stop(struct testbench *bench)
{
    bench->stop = 1;
    machine_stop(&bench->machine);
}

/* Returns false if the firmware has crashed. */
static bool run_controller(struct testbench *bench)
{
    enum machine_end end = machine_run(&bench->machine);
    bench->end = bench->machine.avr->cycle;
    bench->cpu_done = end == MACHINE_DONE;
    testbench_end_host_line(bench);
    if (end == MACHINE_CRASHED) {
        const char *what = bench->machine.crash; // simavr: Invalid read (or write) address
        rules_record_breach(&bench->rules, strstr(what, "address") ? RULE_BAD_ADDRESS : RULE_CRASH,
                            bench->end, "%s", what);
    }
    return end != MACHINE_CRASHED;
}

static void run_adapter(struct testbench *bench)
{
    if (bench->options->pty) {
        testbench_run_adapter_in_realtime(bench);
    }
    while (!bench->stop && schedule_next(&bench->schedule) != SCHEDULE_NEVER) {
        schedule_run_until(&bench->schedule, schedule_next(&bench->schedule));
    }
    bench->end = bench->schedule.now;
}

static const char *why_unfinished(const struct testbench *bench)
{
    if (bench->options->bus) {
        return "";
    }
    if (bench->cpu_done) {
        return ": the firmware sleeps with interrupts off";
    }
    bool over = bench->options->seconds > 0 && !event_armed(&bench->time_limit);
    return over ? ": --seconds were over" : ": interrupted";
}

bool testbench_run(struct testbench *bench)
{
    const struct testbench_options *options = bench->options;
    bool crashed = false;
    testbench_print_client(bench); // from here on a signal ends the run cleanly
    bench->ran = true;
    if (ferror(stdout)) { // full: nobody would see where to connect
        return true;      // files_flush_stdout() tells it
    }
    if (options->bus) {
        run_adapter(bench);
    } else {
        crashed = !run_controller(bench);
    }
    if (options->script && !bench->script.done && !crashed) {
        rules_record_breach(&bench->rules, RULE_SCRIPT_UNFINISHED, bench->end, "%s:%u%s",
                            options->script, script_line_number(&bench->script),
                            why_unfinished(bench));
    }
    if (options->pc && pc_program_is_unfinished(&bench->pc_program) && !crashed) {
        rules_record_breach(&bench->rules, RULE_SCRIPT_UNFINISHED, bench->end, "%s:%u%s",
                            options->pc, pc_program_line_number(&bench->pc_program),
                            why_unfinished(bench));
    }
    live_view_end(&bench->live_view, bench->end);
    if (!options->bus) {
        testbench_flush_client(bench);
    }
    for (unsigned i = 0; i < bench->bus_count; i++) {
        transcript_end(&bench->bus[i].transcript);
        servo_eeprom_save(&bench->bus[i].eeprom);
    }
    return !rules_failed(&bench->rules);
}

/* --- report --- */

static double percent(uint64_t part, uint64_t whole)
{
    return whole ? 100.0 * (double)part / (double)whole : 0.0;
}

static void report_cpu(struct testbench *bench, FILE *out)
{
    const struct cpu *cpu = &bench->machine.cpu;
    fprintf(out, "cpu:     %.1f %% in interrupt handlers, awake %.1f %%\n",
            percent(cpu->in_handlers, bench->end), 100.0 - percent(cpu->asleep, bench->end));
    cycle_log_report(&bench->cycle_log, bench->end, out);
    if (bench->host_link.adapter.framing_errors) {
        fprintf(out, "host:    %" PRIu32 " bytes of the firmware with framing errors: baud rate?\n",
                bench->host_link.adapter.framing_errors);
    }
    if (bench->host_link.overruns) {
        fprintf(out,
                "host:    %" PRIu32
                " bytes of the PC lost (overrun): the firmware had not read the "
                "earlier ones\n",
                bench->host_link.overruns);
    }
}

/* Facts about the firmware that may be why an expectation was not met. */
static void report_hints(const struct testbench *bench, FILE *out)
{
    bool has_console = adapter_end(&bench->host_link.adapter) > 0; // and waits for its lines
    if (!bench->machine.interrupts_were_on) {
        fputs("hint:    the firmware never turned interrupts on: sei()\n", out);
    }
    for (unsigned i = 0; i < bench->bus_count && !has_console; i++) {
        const struct testbench_bus *bus = &bench->bus[i];
        double pause_ms = (double)bus->longest_pause * 1000.0 / bench->clock_Hz;
        if (bus->servos.count && !bus->transcript.packets_in) {
            fprintf(out, "hint:    bus %u: the firmware sent no packet\n", i);
        } else if (pause_ms > PAUSE_MS) {
            fprintf(out,
                    "hint:    bus %u: up to %.1f ms between two packets of the firmware, where a "
                    "robot object has 4 ms: is the main loop slower, or had the robot stopped?\n",
                    i, pause_ms);
        }
    }
}

/* A program that works for itself asks for a servo again and again; a scan asks a few times. */
static void report_absent_servos(const struct testbench_bus *bus, FILE *out)
{
    char list[64];
    bool absent[IDS_MAX] = {false};
    for (unsigned id = 0; id < IDS_MAX; id++) {
        absent[id] = bus->unheard[id] >= UNHEARD_MIN;
    }
    if (memchr(absent, true, sizeof(absent))) {
        fprintf(out,
                "hint:    %sthe firmware asks for servos that are not there: %s; add them to "
                "SERVOS= of make, or to --servos\n",
                bus->where, ids_print(absent, list, sizeof(list)));
    }
}

void testbench_report(struct testbench *bench, FILE *out)
{
    fprintf(out, "time:    %.6f s simulated%s\n", (double)bench->end / bench->clock_Hz,
            bench->cpu_done ? ", ended by the firmware" : "");
    for (unsigned i = 0; i < bench->bus_count; i++) {
        const struct transcript *t = &bench->bus[i].transcript;
        fprintf(out,
                "bus %u:   %" PRIu32 " packets in, %" PRIu32 " out, %" PRIu32
                " damaged; wire busy %.1f %%\n",
                i, t->packets_in, t->packets_out, t->damaged, percent(t->busy, bench->end));
    }
    for (unsigned i = 0; i < bench->bus_count; i++) {
        faults_report(&bench->bus[i].faults, bench->bus[i].where, out);
    }
    if (!bench->options->bus) {
        report_cpu(bench, out);
    } else if (bench->bus[0].adapter.framing_errors) {
        fprintf(out, "adapter: %" PRIu32 " bytes with framing errors: baud rate?\n",
                bench->bus[0].adapter.framing_errors);
    }
    pty_report(&bench->pty, out);
    tcp_report(&bench->tcp, out);
    if (bench->realtime.lost_ns) {
        fprintf(out, "pace:    %.3f s behind real time\n", (double)bench->realtime.lost_ns * 1e-9);
    }
    if (bench->options->script && bench->script.done && !rules_failed(&bench->rules)) {
        fprintf(out, "script:  %u lines done\n", bench->script.next);
    }
    rules_report(&bench->rules, out);
    bool works_for_itself = bench->options->host == TESTBENCH_HOST_NONE ||
                            bench->options->host == TESTBENCH_HOST_STDOUT;
    for (unsigned i = 0; i < bench->bus_count && works_for_itself; i++) {
        report_absent_servos(&bench->bus[i], out);
    }
    bool wrong_line = bench->options->script && !bench->script.unmet;
    if (bench->rules.breaches[RULE_EXPECTATION] && !bench->options->bus && !wrong_line) {
        report_hints(bench, out);
    }
}

/* --- end --- */

static bool save_results(struct testbench *bench)
{
    const char *eeprom = bench->options->eeprom;
    if (!bench->ran) {
        return true;
    }
    bool good = plot_draw(&bench->plot, bench->end);
    if (eeprom) {
        eeprom_model_lose_power(&bench->machine.eeprom, bench->end);
        good = eeprom_model_save(&bench->machine.eeprom, eeprom) && good;
    }
    return good;
}

bool testbench_free(struct testbench *bench)
{
    bool good = save_results(bench);
    good = vcd_close(&bench->vcd) && good;
    good = motion_close(&bench->motion) && good;
    good = cycle_log_close(&bench->cycle_log, bench->end) && good;
    good = files_close(bench->transcript, bench->options->transcript) && good;
    for (unsigned i = 0; i < BOARD_BUSES_MAX; i++) {
        if (bench->bus[i].bench) {
            good = good && !bench->bus[i].eeprom.failed;
            servos_free(&bench->bus[i].servos);
        }
    }
    plot_free(&bench->plot);
    gdb_close(&bench->gdb);
    pty_close(&bench->pty);
    tcp_close(&bench->tcp);
    testbench_close_poke(bench);
    machine_free(&bench->machine);
    script_free(&bench->script);
    pc_program_free(&bench->pc_program);
    schedule_free(&bench->schedule);
    return good;
}
