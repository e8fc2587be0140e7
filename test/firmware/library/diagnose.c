/* SPDX-License-Identifier: MIT */
/* Runs a diagnosis when the host asks for one; further commands prepare it for a test. A line is a
 * letter and numbers. The program answers each line with "ok". */
#include <cds55xx/blocking.h>
#include <cds55xx/queue.h>
#include <cds55xx/avr.h>

#include "say.h"

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_DIAGNOSE_PACKET_SIZE], reply[CDS_DIAGNOSE_REPLY_SIZE];
static struct cds_request request = CDS_REQUEST(packet, reply);
static struct cds_queue queue;
static struct cds_diagnose diagnose;

static void say_tally(const char *name, const struct cds_diagnose_tally *tally)
{
    say(name, tally->asked);
    say("..answered", tally->answered);
    say("..damaged", tally->damaged);
    say("..silent", tally->silent);
    say("..echoed", tally->echoed);
    say("..cut", tally->cut);
}

static void say_found(uint32_t us)
{
    say("us", us);
    say("result", diagnose.steps.result);
    say("finding", diagnose.finding);
    say("found_id", diagnose.found_id);
    say("found_baud", diagnose.found_baud_reg);
    say("value", diagnose.value);
    say("unasked", diagnose.unrequested_bytes);
    say("extra", diagnose.duplicate_replies);
    say("late", diagnose.stale_replies);
    say("foreign", diagnose.unexpected_packets);
    say("echo_errors", diagnose.echo_errors);
    say("overruns", diagnose.overruns);
    say("transactions", diagnose.transactions);
    say_tally("ping", &diagnose.probe);
    say_tally("same", &diagnose.same);
    say_tally("differing", &diagnose.varying);
    say_tally("total", &diagnose.total);
    say("baud", bus.baud_reg);
    say("return_delay_us", bus.return_delay_us);
    say("repeats", queue.retries);
}

static void run(uint8_t id)
{
    uint32_t from_us = cds_port_now_us();

    cds_blocking_diagnose(&diagnose, &(struct cds_diagnose_config){&bus, &request, id});
    say_found(cds_port_now_us() - from_us);
}

static void obey(char letter, const uint16_t *number)
{
    uint8_t id = (uint8_t)number[0], address = (uint8_t)number[1];

    switch (letter) {
    case 'd': run(id); break;
    case 'w': cds_blocking_write_byte(&bus, &request, id, address, (uint8_t)number[2]); break;
    case 'f': // feedback, so many times
        for (uint16_t i = 0; i < number[1]; i++)
            cds_blocking_read(&bus, &request, id, 0x24, 11);
        break;
    case 'r': cds_bus_set_return_delay(&bus, number[0]); break;
    case 'b': cds_bus_set_baud(&bus, (uint8_t)number[0]); break;
    default: say_text("error 30: letter\n"); return;
    }
    say_text("ok\n");
}

static char hear(void)
{
    while (!(UCSR0A & 1 << RXC0))
        cds_bus_poll(&bus);
    return (char)UDR0;
}

int main(void)
{
    say_open();
    UCSR0B |= 1 << RXEN0;
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_queue_attach(&queue, &bus);
    cds_queue_set_retries(&queue, 1);
    for (;;) {
        uint16_t number[3] = {0};
        uint8_t count = 0;
        char letter = hear();

        for (char c = hear(); c != '\n'; c = hear()) {
            if (c == ' ')
                count++;
            else if (c >= '0' && c <= '9' && count >= 1 && count <= 3)
                number[count - 1] = (uint16_t)(number[count - 1] * 10u + (uint8_t)(c - '0'));
        }
        obey(letter, number);
    }
}
