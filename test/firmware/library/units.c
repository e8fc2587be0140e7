/* SPDX-License-Identifier: MIT */
/* Drives a servo in units: to 180 degrees at 31 RPM, then endless at 20 RPM CW. Prints the values
 * that it reads back, in the same units, and the outcome of each transaction that failed. */
#include <cds55xx/control_table.h>
#include <cds55xx/servo.h>
#include <cds55xx/servo_units.h>
#include <cds55xx/blocking.h>
#include <cds55xx/avr.h>
#include <util/delay.h>

#include "say.h"

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

#define ID 1

static uint8_t packet[CDS_PACKET_SIZE(5)], reply[8];
static struct cds_request request = CDS_REQUEST(packet, reply);
static const struct cds_register_profile *const servo = &cds_profile_cds55xx;

static void must(enum cds_result submitted)
{
    enum cds_result result = cds_blocking_for(&bus, &request, submitted);

    if (result != CDS_OK || request.error) {
        say("result", result);
        say("error", request.error);
    }
}

static void say_feedback(void)
{
    int32_t mdeg = 0, mrpm = 0, mV = 0, celsius = 0;

    must(cds_servo_read(&bus, &request, ID, CDS_REG_PRESENT_POSITION, 8));
    cds_servo_units_position_mdeg(&request, 0, &mdeg);
    cds_servo_units_speed_mrpm(&request, 2, servo, &mrpm);
    cds_servo_units_voltage_mV(&request, 6, &mV);
    cds_servo_units_temperature_celsius(&request, 7, &celsius);
    say_signed("mdeg", mdeg);
    say_signed("mrpm", mrpm);
    say_signed("mV", mV);
    say_signed("celsius", celsius);
}

int main(void)
{
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    must(cds_servo_units_torque(&bus, &request, ID, true));
    must(cds_servo_units_move_mdeg(&bus, &request, ID, servo, 180000, 31000));
    _delay_ms(2000);
    say_feedback();
    must(cds_servo_units_limits_mdeg(&bus, &request, ID, 0, 0));
    must(cds_servo_units_turn_mrpm(&bus, &request, ID, servo, -20000));
    _delay_ms(1000);
    say_feedback();
    say_end();
}
