/* SPDX-License-Identifier: MIT */
/* Compares the handlers of avr/handlers.h with the functions of link.h that they implement in
 * assembler. Both get the same links, bytes and errors; the registers of the USART are in RAM.
 * Prints how often they differed, or changed a register or flag of the interrupted code, and the
 * longest time of each handler in cycles, with 4 cycles for the entry and 2 for the vector. */
#include "cds55xx/avr/handlers.h"

#include <string.h>

#include "say.h"

/* Registers and vectors of a bus 7 (two enables) and a bus 8 (tied pins). */
#define BOARD_BUS7_USART F
#define BOARD_BUS8_USART F
#define USARTF_RX_vect   __vector_of_rx
#define USARTF_UDRE_vect __vector_of_udre
#define USARTF_TX_vect   __vector_of_tx

static volatile uint8_t UDRF, UCSRFA, UCSRFB;

static struct {
    uint8_t before[256 - 48]; // the ring crosses a page
    struct cds_link link;
} hand __attribute__((aligned(256)));

CDS_AVR_HANDLERS_TWO_ENABLES(hand, 7)
#undef USARTF_RX_vect
#undef USARTF_UDRE_vect
#undef USARTF_TX_vect
#define USARTF_RX_vect   __vector_of_tied_rx
#define USARTF_UDRE_vect __vector_of_tied_udre
#define USARTF_TX_vect   __vector_of_tied_tx
CDS_AVR_HANDLERS_TIED(hand, 8)

static struct cds_link twin;
static uint8_t twin_data, twin_status, twin_control;

void cds_port_tx(uint8_t port, uint8_t byte)
{
    (void)port;
    twin_data = byte;
}

void cds_port_tx_last(uint8_t port, uint8_t byte)
{
    twin_data = byte;
    twin_status = CDS_AVR_TXC | CDS_AVR_U2X;
    twin_control = port == 8 ? CDS_AVR_STATE_TIED_DRAINING : CDS_AVR_STATE_DRAINING;
}

void cds_port_listen(uint8_t port)
{
    (void)port;
    twin_control = CDS_AVR_STATE_LISTENING;
}

#define ROUNDS 4000

static uint8_t pages[512] __attribute__((aligned(256)));
static uint8_t *const packet = pages + 253; // 258 bytes, of which the third ends a page
static uint16_t wrong, spoilt;
static uint32_t seed = 1;

static uint8_t any(void)
{
    seed = seed * 1664525 + 1013904223;
    return (uint8_t)(seed >> 24);
}

/* Interrupts code whose registers and flags are known. Measures an rcall (3 cycles) and the
 * handler. A real interrupt has 4 cycles of entry and 2 of the rjmp in the vector table in place of
 * the rcall.
 */
#define MORE_THAN_RCALL (4 + 2 - 3)
#define INTERRUPT(vector)                                                                          \
    __extension__({                                                                                \
        uint8_t flags = any() & 0x7F, begun, ended, after, spoils;                                 \
                                                                                                   \
        __asm__ volatile("ldi  r24, 0x69\n\tmov  r0, r24\n\t"                                      \
                         "ldi  r24, 0xA5\n\tldi  r30, 0x3C\n\tldi  r31, 0x96\n\t"                  \
                         "out  __SREG__, %[flags]\n\t"                                             \
                         "in   %[begun], %[counter]\n\t"                                           \
                         "rcall " vector "\n\t"                                                    \
                         "in   %[ended], %[counter]\n\t"                                           \
                         "in   %[after], __SREG__\n\t"                                             \
                         "cli\n\t"                                                                 \
                         "subi r24, 0xA5\n\tsubi r30, 0x3C\n\tsubi r31, 0x96\n\t"                  \
                         "or   r24, r30\n\tor   r24, r31\n\t"                                      \
                         "ldi  r30, 0x69\n\teor  r0, r30\n\tor   r24, r0\n\t"                      \
                         "mov  %[spoils], r24\n\t"                                                 \
                         : [begun] "=&r"(begun), [ended] "=&r"(ended), [after] "=&r"(after),       \
                           [spoils] "=&r"(spoils)                                                  \
                         : [flags] "r"(flags), [counter] "I"(_SFR_IO_ADDR(TCNT1L))                 \
                         : "r0", "r24", "r30", "r31", "memory");                                   \
        spoilt += spoils || after != (flags | 0x80);                                               \
        (uint8_t)(ended - begun - 1 + MORE_THAN_RCALL);                                            \
    })

static void longest(uint8_t *most, uint8_t cycles)
{
    if (cycles > *most)
        *most = cycles;
}

/* Anything that may be, and often what borders on something. */
static void any_link(void)
{
    uint8_t *bytes = (uint8_t *)&twin;
    uint8_t room = any() & 3;

    for (uint8_t i = 0; i < sizeof twin; i++)
        bytes[i] = any();
    twin.state = any() & 3;
    twin.broken = any() & 1 ? CDS_LINK_WHOLE : any() & 1 ? CDS_LINK_DAMAGED : CDS_LINK_FULL;
    twin.rx.tail = (uint8_t)(twin.rx.head - (room ? CDS_RING_SIZE + 1 - room : any() & 63));
    twin.last = packet + 5 + any() % 253;
    twin.cursor = any() & 1 ? twin.last : packet + 1 + any() % (twin.last - packet);
    twin.echo = any() & 1 ? twin.last + 1 : packet + any() % (twin.last - packet + 1);
    if (any() & 1) { // as low byte the same
        twin.last = packet + 257;
        twin.cursor = twin.last - (any() & 1) * 256;
        twin.echo = packet + 2 + (any() & 1) * 256;
    }
    memcpy(&hand.link, &twin, sizeof twin);
    UDRF = twin_data = any() & 1 ? any() : *twin.echo;
    UCSRFA = twin_status =
        (uint8_t)(CDS_AVR_U2X | 1 << 7 | CDS_AVR_UDRE | (any() & 3 ? 0 : any() & 0x18));
    UCSRFB = twin_control = any();
}

static void compare(void)
{
    wrong += memcmp(&hand.link, &twin, sizeof twin) || UDRF != twin_data || UCSRFA != twin_status ||
             UCSRFB != twin_control;
}

static uint8_t line_errors(void)
{
    return (uint8_t)((twin_status & CDS_AVR_FRAMING_ERROR ? CDS_LINE_FRAMING : 0) |
                     (twin_status & CDS_AVR_OVERRUN ? CDS_LINE_OVERRUN : 0));
}

int main(void)
{
    uint8_t rx = 0, udre = 0, tx = 0, tied_rx = 0;

    say_open();
    TCCR1B = 1; // counts cycles
    for (uint16_t i = 0; i < sizeof pages; i++)
        pages[i] = any();
    for (uint16_t i = 0; i < ROUNDS; i++) {
        any_link();
        longest(&rx, INTERRUPT("__vector_of_rx"));
        cds_link_on_rx(&twin, twin_data, line_errors());
        compare();
        any_link();
        longest(&tied_rx, INTERRUPT("__vector_of_tied_rx"));
        cds_link_on_rx_echo(&twin, twin_data, line_errors());
        compare();
        any_link();
        longest(&udre, INTERRUPT("__vector_of_udre"));
        cds_link_on_tx_ready(&twin, 7);
        compare();
        any_link();
        longest(&udre, INTERRUPT("__vector_of_tied_udre"));
        cds_link_on_tx_ready(&twin, 8);
        compare();
    }
    any_link();
    longest(&tx, INTERRUPT("__vector_of_tx"));
    cds_link_on_tx_complete(&twin, 7);
    compare();
    any_link();
    longest(&tx, INTERRUPT("__vector_of_tied_tx"));
    cds_link_on_tx_complete(&twin, 8);
    compare();
    say("differed", wrong);
    say("spoilt", spoilt);
    say("rx", rx);
    say("udre", udre);
    say("tx", tx);
    say("tied_rx", tied_rx);
    say_end();
}
