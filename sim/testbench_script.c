/* SPDX-License-Identifier: MIT */
/* What a scenario can do to the testbench: struct script_ops, with and without a controller. */
#include "testbench.h"

static bool console_is_ready(void *context)
{
    struct testbench *bench = context;
    return bench->board.has_host && usart_rxen(&bench->host_link.usart);
}

static void send_to_console(void *context, uint64_t now, const char *bytes, size_t size)
{
    struct testbench *bench = context;
    host_link_send(&bench->host_link, now, bytes, size);
}

static uint64_t send_to_bus(void *context, uint64_t now, const uint8_t *bytes, size_t size)
{
    struct testbench *bench = context;
    adapter_send(&bench->bus[0].adapter, now, bytes, size);
    return adapter_end(&bench->bus[0].adapter);
}

static void set_baud(void *context, uint32_t baud)
{
    struct testbench *bench = context;
    adapter_baud(&bench->bus[0].adapter, baud);
}

static struct servos *servos_of_bus(void *context, unsigned index)
{
    struct testbench *bench = context;
    return index < bench->bus_count ? &bench->bus[index].servos : 0;
}

static void replace_servos(void *context, uint64_t now, const uint8_t *ids, unsigned count)
{
    struct testbench *bench = context;
    if (!testbench_put_servos(&bench->bus[0], now, ids, count)) {
        testbench_stop(bench);
    }
    motion_new_servos(&bench->motion, now);
}

const char *testbench_fault(void *context, uint64_t now, const char *text)
{
    struct testbench *bench = context;
    unsigned bus = fault_order_bus(text);
    if (bus >= bench->bus_count) {
        return bench->options->bus ? "there is no such bus" : "the board has no such bus";
    }
    return faults_order(&bench->bus[bus].faults, now, text);
}

void testbench_reset(void *context, uint64_t now, const struct reset_order *order)
{
    struct testbench *bench = context;
    reset_injection_order(&bench->reset, now, order);
}

void testbench_echo(void *context, bool on)
{
    struct testbench *bench = context;
    testbench_end_host_line(bench);
    for (unsigned i = 0; i < bench->bus_count; i++) {
        bench->bus[i].transcript.echo = on ? stdout : 0;
    }
}

static void line_has_outcome(void *context, uint64_t now, enum script_outcome outcome,
                             const char *what)
{
    static const enum rule rule[] = {
        [SCRIPT_UNEXPECTED_ERROR] = RULE_REPLY_WAS_ERROR,
        [SCRIPT_UNEXPECTED_OK] = RULE_REPLY_WAS_OK,
        [SCRIPT_SILENCE] = RULE_SCRIPT_UNFINISHED,
        [SCRIPT_UNMET] = RULE_EXPECTATION,
    };
    struct testbench *bench = context;
    if (outcome != SCRIPT_GOOD) {
        rules_record_breach(&bench->rules, rule[outcome], now, "%s:%u: %s", bench->options->script,
                            script_line_number(&bench->script), what);
    }
}

/* With a pty the client goes on after the scenario has ended. */
static void script_finished(void *context, uint64_t now)
{
    struct testbench *bench = context;
    (void)now;
    if (!bench->options->pty) {
        testbench_stop(bench);
    }
}

void testbench_set_script_ops(struct testbench *bench)
{
    bench->ops = (struct script_ops){
        .context = bench,
        .bus = servos_of_bus,
        .servos = replace_servos,
        .fault = testbench_fault,
        .echo = testbench_echo,
        .rules = &bench->rules,
        .outcome = line_has_outcome,
        .finished = script_finished,
    };
    if (bench->options->bus) {
        bench->ops.bus_send = send_to_bus;
        bench->ops.bus_baud = set_baud;
    } else {
        bench->ops.console_ready = console_is_ready;
        bench->ops.console_send = bench->board.has_host ? send_to_console : 0;
        bench->ops.has_text = bench->board.has_host;
        bench->ops.reset = testbench_reset;
    }
}

bool testbench_start_script(struct testbench *bench)
{
    testbench_set_script_ops(bench);
    bench->script.echo = bench->options->echo;
    return script_start(&bench->script, &bench->schedule, bench->clock_Hz, &bench->ops, stdout);
}
