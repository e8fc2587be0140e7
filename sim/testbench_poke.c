/* SPDX-License-Identifier: MIT */
/* Orders during a run in real time: --poke SOCKET. An order is a line of a scenario that begins
 * with @; the script runs it as a scenario of one line. */
#include "testbench.h"

#include <stdlib.h>

#include "memory.h"

/* A message names orders as a scenario has them, "@power"; the order of a client has no @. */
static void print_error(FILE *out, const char *wrong)
{
    fputs("error: ", out);
    for (const char *at = wrong; *at; at++) {
        if (*at != '@') {
            fputc(*at, out);
        } else if (at[1] == ' ') {
            at++;
        }
    }
    fputc('\n', out);
}

/* Says what a person may overlook: `load 1` means all servos, and a servo may have no power. */
static void print_notes(struct testbench *bench)
{
    const struct scenario_line *line = bench->script.scenario.line;
    FILE *out = bench->script.out;
    unsigned place = 0;
    if (line->verb != SCENARIO_ENVIRONMENT) {
        return;
    }
    if (line->all) {
        fprintf(out, "all servos: %s\n", line->source + 1);
    }
    for (unsigned bus = 0; bus < bench->bus_count; bus++) {
        const struct servos *servos = &bench->bus[bus].servos;
        for (unsigned i = 0; i < servos->count; i++) {
            const struct servo_node *node = &servos->node[i];
            place++;
            bool named = place == line->place || line->all || line->ids[node->id];
            if (!node->servo.powered && named && environment_is_dead(node)) {
                fprintf(out, "servo %u is off below 3 V: 'supply %u 12' starts it\n", node->id,
                        node->id);
            } else if (!node->servo.powered && line->property != ENVIRONMENT_POWER && named) {
                fprintf(out, "servo %u is off: switch it on with 'power %u on'\n", node->id,
                        node->id);
            }
        }
    }
}

static void answer(struct testbench *bench, const char *wrong)
{
    struct testbench_poke *poke = &bench->poke;
    if (wrong[0]) {
        print_error(bench->script.out, wrong);
    } else {
        print_notes(bench);
        fputs("ok\n", bench->script.out);
    }
    fclose(bench->script.out);
    bench->script.out = stdout;
    poke_socket_answer(&poke->socket, poke->output, poke->output_size);
    free(poke->output);
    poke->busy = false;
}

static void order_has_outcome(void *context, uint64_t now, enum script_outcome outcome,
                              const char *what)
{
    struct testbench *bench = context;
    (void)now;
    if (outcome != SCRIPT_GOOD) {
        snprintf(bench->poke.wrong, sizeof(bench->poke.wrong), "%s", what);
    }
}

static void order_finished(void *context, uint64_t now)
{
    struct testbench *bench = context;
    (void)now;
    answer(bench, bench->poke.wrong);
}

bool testbench_open_poke(struct testbench *bench)
{
    testbench_set_script_ops(bench);
    bench->ops.console_ready = 0; // the console belongs to the client
    bench->ops.console_send = 0;
    bench->ops.outcome = order_has_outcome;
    bench->ops.finished = order_finished;
    script_start_empty(&bench->script, &bench->schedule, bench->clock_Hz, &bench->ops, stdout);
    return poke_socket_open(&bench->poke.socket, bench->options->poke);
}

static void begin(struct testbench *bench, uint64_t now, const char *line)
{
    struct testbench_poke *poke = &bench->poke;
    char what[SCRIPT_WHAT_SIZE];
    bench->script.out = memory_checked(open_memstream(&poke->output, &poke->output_size));
    poke->busy = true;
    poke->wrong[0] = 0;
    const char *wrong = script_order(&bench->script, now, line, what);
    if (wrong) {
        answer(bench, wrong);
    }
}

void testbench_poll_poke(struct testbench *bench, uint64_t now)
{
    struct testbench_poke *poke = &bench->poke;
    if (poke->socket.listener < 0) {
        return;
    }
    if (poke->busy && poke_socket_client_left(&poke->socket)) {
        script_cancel(&bench->script);
        answer(bench, "the client has left");
    }
    const char *line = poke->busy ? 0 : poke_socket_read(&poke->socket);
    if (line) {
        begin(bench, now, line);
    }
}

void testbench_close_poke(struct testbench *bench)
{
    if (bench->poke.busy) {
        script_cancel(&bench->script);
        answer(bench, "the simulation has ended");
    }
    poke_socket_close(&bench->poke.socket);
}
