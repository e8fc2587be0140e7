/* SPDX-License-Identifier: MIT */
/* Three buses of an arduino-mega at once, with one servo each (bus 0: ID 1, bus 1: ID 2, bus 2: ID
 * 3). READs follow each other on all buses. Bytes of the EEPROM: 0  return delay of the servos, in
 * units of 2 us 1  registers in each READ 2  number of buses, from bus 0 on 3  seconds (FF: 1) 4
 * additional registers on each further bus (FF: 0), so that transactions overlap differently Prints
 * the counters of each bus, and the longest time from one READ to the next. */
#include <avr/eeprom.h>
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>
#include <stdbool.h>

#include "say.h"

#define BUSES       3
#define SECOND_US   1000000ul
#define ERASED      0xFF
#define SECONDS_MAX 15 // the counts have 16 bits

static struct cds_bus bus[BUSES];
CDS_AVR_BUS(bus[0], 0)
CDS_AVR_BUS(bus[1], 1)
CDS_AVR_BUS(bus[2], 2)
CDS_AVR_CLOCK()

static uint8_t packet[BUSES][CDS_PACKET_SIZE(2)], reply[BUSES][CDS_REPLY_MAX];
static struct cds_request request[BUSES] = {CDS_REQUEST(packet[0], reply[0]),
                                            CDS_REQUEST(packet[1], reply[1]),
                                            CDS_REQUEST(packet[2], reply[2])};
static uint8_t length, more, buses;
static uint16_t reads[BUSES], good[BUSES], refused[BUSES];
static uint32_t begun_us[BUSES], longest_us[BUSES];

static void read_next(uint8_t i)
{
    uint32_t now_us = cds_port_now_us();

    if (reads[i]++ && now_us - begun_us[i] > longest_us[i])
        longest_us[i] = now_us - begun_us[i];
    begun_us[i] = now_us;
    cds_servo_read(&bus[i], &request[i], (uint8_t)(i + 1), CDS_REG_ID,
                   (uint8_t)(length + i * more));
}

/* Counts the reply; it is good if it holds the ID of the servo. */
static void judge(uint8_t i)
{
    uint8_t id = 0;
    enum cds_result result = cds_request_byte(&request[i], 0, &id);

    if (result == CDS_OK && id == i + 1)
        good[i]++;
    if (result == CDS_REFUSED) // the packet was damaged on its way to the servo
        refused[i]++;
}

static void open_all(uint8_t delay)
{
    for (uint8_t i = 0; i < buses; i++) {
        cds_bus_open(&bus[i], i, CDS_BAUD_1M);
        cds_servo_write_byte(&bus[i], &request[i], CDS_BROADCAST_ID, CDS_REG_RETURN_DELAY, delay);
        while (cds_bus_poll(&bus[i])) {
        }
        cds_bus_open(&bus[i], i, CDS_BAUD_1M); // counters at 0
    }
}

static uint32_t read_all(uint8_t seconds)
{
    uint32_t from_us = cds_port_now_us(), turns = 0;
    uint32_t time_us = SECOND_US * (seconds > SECONDS_MAX ? 1 : seconds);

    for (uint8_t i = 0; i < buses; i++)
        read_next(i);
    for (; cds_port_now_us() - from_us < time_us; turns++) {
        for (uint8_t i = 0; i < buses; i++) {
            if (!cds_bus_poll(&bus[i])) {
                judge(i);
                read_next(i);
            }
        }
    }
    for (uint8_t i = 0; i < buses; i++) {
        while (cds_bus_poll(&bus[i])) {
        }
        judge(i);
    }
    return turns;
}

static void say_counters(uint8_t i)
{
    struct cds_stats count;

    cds_bus_stats(&bus[i], &count);
    say("bus", i);
    say("reads", reads[i]);
    say("good", good[i]);
    say("refused", refused[i]);
    say("sent", count.sent);
    say("unsent", count.line_busy);
    say("ok", count.ok);
    say("timeouts", count.timeouts);
    say("corrupt", count.corrupt);
    say("overruns", count.overruns);
    say("refuted", count.malformed);
    say("foreign", count.unexpected_packets);
    say("framing", count.framing_errors);
    say("overflows", count.ring_overflows);
    say("longest_us", longest_us[i]);
}

int main(void)
{
    uint32_t turns;

    say_open();
    cds_avr_clock_open();
    sei();
    length = eeprom_read_byte((const uint8_t *)1);
    buses = eeprom_read_byte((const uint8_t *)2);
    more = eeprom_read_byte((const uint8_t *)4);
    if (more == ERASED)
        more = 0;
    open_all(eeprom_read_byte((const uint8_t *)0));
    turns = read_all(eeprom_read_byte((const uint8_t *)3));
    say("turns", turns);
    for (uint8_t i = 0; i < buses; i++)
        say_counters(i);
    say_end();
}
