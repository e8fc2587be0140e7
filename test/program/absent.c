/* What the main loop does while a servo does not answer: it turns. Says on the host USART how
 * often, for how long in microseconds, and how the exchange ended. */
#include <cds55xx/servo.h>
#include <cds55xx_avr.h>
#include <avr/sleep.h>
#include <stdlib.h>

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static void say(const char *word, uint32_t number)
{
    char text[11];

    ultoa(number, text, 10);
    for (const char *at = word; *at; at++) {
        loop_until_bit_is_set(UCSR0A, UDRE0);
        UDR0 = (uint8_t)*at;
    }
    for (const char *at = text; *at; at++) {
        loop_until_bit_is_set(UCSR0A, UDRE0);
        UDR0 = (uint8_t)*at;
    }
}

int main(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(2)];
    static struct cds_request request = CDS_REQUEST(packet);
    uint32_t turns = 0, from_us, submit_us;

    UCSR0A = 1 << U2X0;
    UBRR0L = 16;
    UCSR0B = 1 << TXEN0;
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, 2);

    from_us = cds_port_now_us();
    cds_servo_read(&bus, &request, 99, CDS_REG_PRESENT_POSITION, 2);
    submit_us = cds_port_now_us() - from_us;
    while (cds_bus_poll(&bus))
        turns++;
    from_us = cds_port_now_us() - from_us;

    say("turns ", turns);
    say(" submit_us ", submit_us);
    say(" us ", from_us);
    say(" result ", request.result);
    say("\n", 0);
    UCSR0A = 1 << TXC0 | 1 << U2X0;
    loop_until_bit_is_set(UCSR0A, TXC0);
    cli();
    sleep_enable();
    sleep_cpu();
}
