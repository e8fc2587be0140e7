/* What a program on an AVR needs besides <cds55xx/...>: one macro binds a USART to a bus of the
 * program's, one starts the clock. All other interrupt vectors stay the program's own.
 *
 *     static struct cds_bus bus;
 *     CDS_AVR_BUS(bus, 0)
 *     CDS_AVR_CLOCK()
 *
 * The handlers know their bus and their registers at compile time: a second bus costs RAM, not
 * cycles. The program calls cds_avr_clock_open() and sei() before it opens the bus.
 *
 * Other handlers of the program hold up those of the bus. At 1 Mbps a receive handler may wait 320
 * cycles before a byte is lost. A reply is lost when the transmit-complete handler waits longer
 * than the servo's return delay, register 0x05 x 32 cycles: raise that register, or begin longer
 * handlers with ISR_NOBLOCK. The handlers of other buses are among them: with three buses busy at
 * once, 5 (10 us) is enough.
 */
#ifndef CDS55XX_AVR_H
#define CDS55XX_AVR_H

#ifndef __OPTIMIZE__
#error "compile with -Os: the handlers must be inlined to keep up with 1 Mbps"
#endif

#include <avr/interrupt.h>

#include "cds55xx/link.h" // the events
#include "clock.h"        // cds_avr_clock_open()
#include "handlers.h"     // AVR_ON_*
#include "timer.h"        // TIMER_OVERFLOW_VECTOR
#include "usart.h"        // the verbs, inline

/* The three verbs an event may use, inlined wherever this header is included; the functions that
 * the core calls are in usart.c. */
AVR_INLINE void cds_port_tx(uint8_t port, uint8_t byte)
{
    avr_usart_tx(port, byte);
}

AVR_INLINE void cds_port_tx_last(uint8_t port, uint8_t byte)
{
    avr_usart_tx_last(port, byte);
}

AVR_INLINE void cds_port_listen(uint8_t port)
{
    avr_usart_listen(port);
}

/* Status goes with the byte and must be read before it. */
static inline void cds_avr_receive_(struct cds_link *link, uint8_t port)
{
    struct avr_usart usart = avr_usart(port);
    uint8_t status = *usart.ucsra & (AVR_FRAMING_ERROR | AVR_OVERRUN);
    uint8_t byte = *usart.udr;
    uint8_t errors = 0;

    if (status & AVR_FRAMING_ERROR)
        errors |= CDS_LINE_FRAMING;
    if (status & AVR_OVERRUN)
        errors |= CDS_LINE_OVERRUN;
    if (usart.echoes)
        cds_link_on_rx_echo(link, byte, errors);
    else
        cds_link_on_rx(link, byte, errors);
}

#ifdef USART_RX_vect // one USART only, without a number
#define CDS_AVR_VECTOR_(usart, event) USART_##event##_vect
#else
#define CDS_AVR_VECTOR_(usart, event) AVR_PASTE3(USART, usart, _##event##_vect)
#endif

/* A receiver that is off while the bus talks: handlers.h. */
#define CDS_AVR_HANDLERS_TWO_ENABLES(bus, number) CDS_AVR_HANDLERS_DEAF_(bus, number)
#define CDS_AVR_HANDLERS_ONE_ENABLE(bus, number)  CDS_AVR_HANDLERS_DEAF_(bus, number)
#define CDS_AVR_HANDLERS_ADAPTER(bus, number)     CDS_AVR_HANDLERS_DEAF_(bus, number)
#define CDS_AVR_HANDLERS_DEAF_(bus, number)                                                        \
    ISR(CDS_AVR_VECTOR_(AVR_BUS(number, _USART), RX), ISR_NAKED)                                   \
    {                                                                                              \
        AVR_ON_RX_((bus).link, number);                                                            \
    }                                                                                              \
    ISR(CDS_AVR_VECTOR_(AVR_BUS(number, _USART), UDRE), ISR_NAKED)                                 \
    {                                                                                              \
        AVR_ON_TX_READY_((bus).link, number);                                                      \
    }                                                                                              \
    ISR(CDS_AVR_VECTOR_(AVR_BUS(number, _USART), TX), ISR_NAKED)                                   \
    {                                                                                              \
        avr_usart_turn_around(number);                                                             \
        AVR_ON_TX_COMPLETE_((bus).link, number);                                                   \
    }

/* One that hears all that is sent: the events in C, for they have more to do. */
#define CDS_AVR_HANDLERS_TIED(bus, number)         CDS_AVR_HANDLERS_ECHO_(bus, number)
#define CDS_AVR_HANDLERS_ADAPTER_ECHO(bus, number) CDS_AVR_HANDLERS_ECHO_(bus, number)
#define CDS_AVR_HANDLERS_ECHO_(bus, number)                                                        \
    ISR(CDS_AVR_VECTOR_(AVR_BUS(number, _USART), RX))                                              \
    {                                                                                              \
        cds_avr_receive_(&(bus).link, number);                                                     \
    }                                                                                              \
    ISR(CDS_AVR_VECTOR_(AVR_BUS(number, _USART), UDRE))                                            \
    {                                                                                              \
        cds_link_on_tx_ready(&(bus).link, number);                                                 \
    }                                                                                              \
    ISR(CDS_AVR_VECTOR_(AVR_BUS(number, _USART), TX))                                              \
    {                                                                                              \
        cds_link_on_tx_complete(&(bus).link, number);                                              \
    }

/* Binds bus `number` (0 to BOARD_BUS_COUNT - 1, a plain number) of the board to `bus`, a struct
 * cds_bus with static storage. At file scope, once for each bus.
 *
 * A servo may answer 32 cycles after the last stop bit: so the transmit-complete handler turns the
 * line around before anything is saved. */
#define CDS_AVR_BUS(bus, number) AVR_PASTE(CDS_AVR_HANDLERS_, AVR_BUS(number, _WIRING))(bus, number)

/* Binds the board's BOARD_CLOCK_TIMER. At file scope, once. */
#define CDS_AVR_CLOCK()                                                                            \
    struct cds_avr_clock cds_avr_clock;                                                            \
    ISR(TIMER_OVERFLOW_VECTOR, ISR_NOBLOCK) /* the line's turnaround must not wait for it */       \
    {                                                                                              \
        cds_avr_clock.overflows_us += AVR_CLOCK_OVERFLOW_US;                                       \
    }

#endif
