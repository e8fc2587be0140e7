/* SPDX-License-Identifier: MIT */
/* The AVR program of `make faults` (test/faults): runs the jobs that the host writes to job_board,
 * one after the other. Between two jobs it polls an idle bus, as the main loop of a robot does. */
#include <cds55xx/queue.h>
#include <cds55xx/scan.h>
#include <cds55xx/servo.h>
#include <cds55xx/servos.h>
#include <cds55xx/avr.h>
#include <string.h>
#include <util/delay_basic.h>

#include "../../faults/job.h"

#ifdef TIMSK0
#define HOLD_INTERRUPTS TIMSK0
#else
#define HOLD_INTERRUPTS TIMSK // ATmega128
#endif

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

__attribute__((used)) volatile struct job_board job_board;

static uint8_t packet[CDS_PACKET_SIZE(1 + JOB_DATA_MAX)], reply[JOB_DATA_MAX];
static uint8_t sent[sizeof(packet)]; // the packet as it was submitted
static struct cds_request request = CDS_REQUEST(packet, reply);
static struct cds_queue queue;
static struct cds_servos servos;
static struct cds_servo_state states[] = {{.id = 1}, {.id = 2}};

/* A handler of the program that is too long. Timer 0 does not run: the host raises the interrupt.
 */
ISR(TIMER0_OVF_vect)
{
    _delay_loop_2(job_board.hold_loops);
}

static enum cds_result submit(const struct job *job)
{
    switch (job->kind) {
    case JOB_PING: return cds_servo_ping(&bus, &request, job->id);
    case JOB_READ: return cds_servo_read(&bus, &request, job->id, job->address, job->length);
    case JOB_WRITE:
        return cds_servo_write(&bus, &request, job->id, job->address, job->data, job->length);
    case JOB_REG_WRITE:
        return cds_servo_reg_write(&bus, &request, job->id, job->address, job->data, job->length);
    default: return cds_servo_action(&bus, &request, job->id);
    }
}

static void attach_servos(enum job_servos how)
{
    static const struct cds_servos_config config = {.bus = &bus,
                                                    .queue = &queue,
                                                    .states = states,
                                                    .count = sizeof(states) / sizeof(states[0]),
                                                    .capacity = sizeof(states) / sizeof(states[0])};

    bus.hooks = 0;
    if (how == JOB_WITHOUT_SERVOS)
        cds_queue_attach(&queue, &bus);
    else if (how == JOB_NEW_SERVOS)
        cds_servos_begin(&servos, &config);
    else
        cds_bus_attach(&bus, &servos.hooks);
}

static void report_known(struct job_known *known)
{
    const struct cds_servo_state *servo = &states[0];

    known->counters = servo->counters;
    known->return_delay = servo->return_delay;
    known->status_return_level = servo->status_return_level;
    known->alarms = servo->alarms;
    known->presence = servo->presence;
    known->misses = servo->misses;
    known->inhibited = servo->inhibits;
    known->torque = servo->torque;
}

/* Polls as a main loop does, until a ring full of noise is read and the line was quiet for two byte
 * times. */
static void look(void)
{
    PORTB = JOB_LOOKS; // a changed value: the host notices only changes of PORTB
    for (uint8_t i = 0; i < CDS_RING_SIZE / CDS_PARSER_SKIPPED_MAX + 8; i++)
        cds_bus_poll(&bus);
}

/* Content of a buffer behind the packet or the reply. */
#define UNTOUCHED 0xA5

static void clean_buffers(void)
{
    memset(packet, UNTOUCHED, sizeof(packet));
    memset(reply, UNTOUCHED, sizeof(reply));
}

/* Returns the number of bytes that changed: in the packet since it was submitted, and in the reply
 * buffer behind the reply. */
static uint8_t spilled(void)
{
    uint8_t due = request.reply_parameters == CDS_REPLY_NONE ? 0 : request.reply_parameters;
    uint8_t count = 0;

    if (due < request.length)
        due = request.length;
    for (uint8_t i = 0; i < sizeof(packet); i++)
        if (packet[i] != sent[i])
            count++;
    for (uint8_t i = due; i < sizeof(reply); i++)
        if (reply[i] != UNTOUCHED)
            count++;
    return count;
}

static void transact(const struct job *job, struct job_outcome *outcome)
{
    for (uint8_t i = 0; i < job->pause; i++) {
        _delay_loop_2(F_CPU / 4 / 10000);
    }
    cds_bus_set_return_delay(&bus,
                             job->return_delay ? 2u * job->return_delay : CDS_RETURN_DELAY_MAX_US);
    attach_servos(job->servos);
    cds_queue_set_retries(&queue, job->retries);
    clean_buffers();
    PORTB = JOB_BEGUN;
    outcome->submitted = submit(job);
    memcpy(sent, packet, sizeof(packet));
    if (outcome->submitted == CDS_OK) {
        while (request.result == CDS_PENDING) {
            cds_bus_poll(&bus);
        }
    }
    PORTB = JOB_ENDED;
    outcome->result = outcome->submitted == CDS_OK ? request.result : outcome->submitted;
    outcome->id = request.id;
    outcome->error = request.error;
    outcome->length = request.length;
    outcome->spilled = spilled();
    for (uint8_t i = 0; i < JOB_DATA_MAX; i++) {
        outcome->data[i] = 0;
        cds_request_byte(&request, i, &outcome->data[i]);
    }
}

static void scan(const struct job *job, struct job_outcome *outcome)
{
    struct cds_scan_found found[JOB_FOUND_MAX];
    struct cds_scan scan = {0};
    struct cds_scan_config config = {.bus = &bus,
                                     .request = &request,
                                     .found = found,
                                     .found_capacity = JOB_FOUND_MAX,
                                     .first_id = job->id,
                                     .last_id = job->address,
                                     .reads_details = job->kind == JOB_SCAN_LISTED};

    if (job->kind == JOB_SCAN) {
        config.baud_regs = &bus.baud_reg;
        config.baud_count = 1;
    }
    cds_scan_begin(&scan, &config);
    PORTB = JOB_BEGUN;
    while (cds_scan_poll(&scan) == CDS_PENDING) {
        cds_bus_poll(&bus);
    }
    PORTB = JOB_ENDED;
    outcome->result = scan.steps.result;
    outcome->asked = scan.asked;
    outcome->found = scan.count;
    for (uint8_t i = 0; i < scan.count && i < JOB_FOUND_MAX; i++) {
        outcome->ids[i] = found[i].id;
        outcome->baud_regs[i] = found[i].baud_reg;
        outcome->own_baud_regs[i] = found[i].own_baud_reg;
    }
}

static void perform(void)
{
    struct job job = job_board.job;
    struct job_outcome outcome = {0};
    struct cds_stats stats;

    if (job.kind == JOB_SCAN || job.kind == JOB_SCAN_LISTED) {
        attach_servos(JOB_WITHOUT_SERVOS);
        scan(&job, &outcome);
    } else if (job.kind == JOB_LOOK) {
        look();
    } else {
        transact(&job, &outcome);
    }
    cds_bus_stats(&bus, &stats);
    outcome.stats = stats;
    outcome.state = cds_bus_line(&bus);
    outcome.alarms = servos.alarms;
    report_known(&outcome.known);
    job_board.outcome = outcome;
}

int main(void)
{
    job_board.hold_vector = TIMER0_OVF_vect_num;
    HOLD_INTERRUPTS |= 1 << TOIE0;
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    for (;;) {
        cds_bus_poll(&bus);
        if (job_board.go) {
            perform();
            job_board.go = 0;
            PORTB = JOB_READY;
        }
    }
}
