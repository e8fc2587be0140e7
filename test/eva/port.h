/* The port of the analysis: every verb returns any value that port.h allows. */
#ifndef EVA_PORT_H
#define EVA_PORT_H

#include "cds55xx/port.h"

#include "any.h"

void cds_port_open(uint8_t port, uint8_t baud)
{
    (void)port, (void)baud;
}

void cds_port_high_z(uint8_t port)
{
    (void)port;
}

void cds_port_listen(uint8_t port)
{
    (void)port;
}

uint8_t cds_port_talk(uint8_t port, uint8_t byte)
{
    (void)port, (void)byte;
    return (uint8_t)any_in(1, 2);
}

void cds_port_follow(uint8_t port)
{
    (void)port;
}

void cds_port_tx(uint8_t port, uint8_t byte)
{
    (void)port, (void)byte;
}

void cds_port_tx_last(uint8_t port, uint8_t byte)
{
    (void)port, (void)byte;
}

bool cds_port_line_is_high(uint8_t port)
{
    (void)port;
    return any_bool();
}

uint32_t cds_port_now_us(void)
{
    return (uint32_t)any_word() << 16 | any_word();
}

uint16_t cds_port_ticks(void)
{
    return any_word();
}

uint8_t cds_port_set_alarm(uint8_t port, uint16_t from, uint16_t count, uint16_t each_us,
                           uint16_t more_us)
{
    (void)port, (void)from, (void)count, (void)each_us, (void)more_us;
    return (uint8_t)any_in(0, 31);
}

bool cds_port_alarm_rings(uint8_t port)
{
    (void)port;
    return any_bool();
}

void cds_port_silence_alarm(uint8_t port)
{
    (void)port;
}

#endif
