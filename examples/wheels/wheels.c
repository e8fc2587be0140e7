/* SPDX-License-Identifier: MIT */
/* A cart with two wheels, servos 1 (left) and 2 (right), in endless turn. The PC sends a line with
 * the speed of each wheel in RPM, for example "20 -20", at 115200 baud; the cart answers ok.
 * Without a line for 500 ms the wheels stop: the PC or its cable has failed. */
#include <cds55xx/avr.h>
#include <cds55xx/blocking.h>
#include <cds55xx/servo_units.h>
#include <stdlib.h>

#define LINK_LOSS_US 500000ul
#define WHEELS       2
#define FASTEST_RPM  60
#define BAUD         115200ul

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_PACKET_SIZE(5)], reply[4];
static struct cds_request request = CDS_REQUEST(packet, reply);

static void uart_open(void)
{
    UCSR0A = 1 << U2X0;
    UBRR0 = (F_CPU + 4 * BAUD) / (8 * BAUD) - 1;
    UCSR0B = 1 << RXEN0 | 1 << TXEN0;
}

static void uart_print(const char *text)
{
    for (; *text; text++) {
        while (!(UCSR0A & 1 << UDRE0)) {
        }
        UDR0 = (uint8_t)*text;
    }
}

/* Adds the byte that has come to the line. True: the line is complete. A line of more than 15
 * characters is empty then, which obey() refuses: a part of a number is another number. */
static bool has_line(char line[16])
{
    static uint8_t length;
    char byte;

    if (!(UCSR0A & 1 << RXC0))
        return false;
    byte = (char)UDR0;
    if (byte == '\r' || byte == '\n') {
        bool any = length > 0;

        line[length <= 15 ? length : 0] = 0;
        length = 0;
        return any;
    }
    if (length < 15)
        line[length] = byte;
    if (length <= 15)
        length++;
    return false;
}

/* Prepares a wheel, which then stands still with torque on. Endless turn: both angle limits are 0.
 * They are in EEPROM, so they are written only if they differ. */
static bool prepare(uint8_t id)
{
    enum cds_result result = cds_blocking_read(&bus, &request, id, CDS_REG_CW_ANGLE_LIMIT, 4);

    if (result == CDS_OK && (reply[0] | reply[1] | reply[2] | reply[3]))
        result =
            cds_blocking_for(&bus, &request, cds_servo_units_limits_mdeg(&bus, &request, id, 0, 0));
    if (result == CDS_OK)
        result = cds_blocking_write_word(&bus, &request, id, CDS_REG_MOVING_SPEED, 0);
    if (result == CDS_OK)
        result = cds_blocking_write_byte(&bus, &request, id, CDS_REG_TORQUE_ENABLE, 1);
    return result == CDS_OK;
}

/* False: a servo does not answer, or refuses. */
static bool turn(int16_t left_rpm, int16_t right_rpm)
{
    const int16_t rpm[WHEELS] = {left_rpm, right_rpm};
    bool good = true;

    for (uint8_t i = 0; i < WHEELS; i++)
        if (cds_blocking_for(&bus, &request,
                             cds_servo_units_turn_mrpm(&bus, &request, (uint8_t)(i + 1),
                                                       &cds_profile_cds55xx, 1000l * rpm[i])) !=
            CDS_OK)
            good = false;
    return good;
}

/* False: the line is not two numbers from -60 to 60, or turn() fails. */
static bool obey(const char *line)
{
    char *first_end, *end;
    long left = strtol(line, &first_end, 10), right = strtol(first_end, &end, 10);

    return end != first_end && *end == 0 && labs(left) <= FASTEST_RPM &&
           labs(right) <= FASTEST_RPM && turn((int16_t)left, (int16_t)right);
}

int main(void)
{
    char line[16];
    uint32_t heard_us = 0;
    bool is_driving = false, is_good = true;

    uart_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    while (cds_port_now_us() < 1000000ul) { // the servos start up
    }
    for (uint8_t id = 1; id <= WHEELS; id++)
        is_good = prepare(id) && is_good;
    uart_print(is_good ? "ready\r\n" : "a servo does not answer\r\n");
    for (;;) {
        if (has_line(line)) {
            heard_us = cds_port_now_us();
            is_driving = true;
            uart_print(obey(line) ? "ok\r\n" : "error 1: bad line, or a servo does not answer\r\n");
        } else if (is_driving && cds_port_now_us() - heard_us >= LINK_LOSS_US) {
            is_driving = !turn(0, 0); // tried again until both wheels have stopped
        }
    }
}
