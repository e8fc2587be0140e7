/* SPDX-License-Identifier: MIT */
#include "avr/usart.h"

#include <string.h>

#include "avr/cpu.h"

/* These bits are the same in every AVR with this USART. */
enum {
    UCSRA_RXC = 0x80,
    UCSRA_TXC = 0x40,
    UCSRA_UDRE = 0x20,
    UCSRA_FE = 0x10,
    UCSRA_DOR = 0x08,
    UCSRA_U2X = 0x02,
    UCSRA_MPCM = 0x01,
    UCSRB_RXEN = 0x10,
    UCSRB_TXEN = 0x08,
    UCSRB_UCSZ2 = 0x04,
    UCSRC_FORMAT = 0x7E, // mode, parity, stop bits, size
    UCSRC_8N1 = 0x06,
    FIFO_SIZE = 2,
};

static uint8_t *ucsra(const struct usart *usart)
{
    return &usart->avr->data[usart->registers->r_ucsra];
}

static uint8_t *ucsrb(const struct usart *usart)
{
    return &usart->avr->data[usart->registers->r_ucsrb];
}

static uint8_t *ucsrc(const struct usart *usart)
{
    return &usart->avr->data[usart->registers->r_ucsrc];
}

void usart_notify(struct usart *usart, enum usart_event event, uint64_t now)
{
    if (usart->on_event) {
        usart->on_event(usart->context, event, now);
    }
}

static uint64_t write_time(const struct usart *usart)
{
    return usart->avr->cycle + USART_WRITE_CYCLES;
}

uint32_t usart_bit_time_256(const struct usart *usart)
{
    const avr_uart_t *r = usart->registers;
    const uint8_t *data = usart->avr->data;
    uint32_t ubrr = (uint32_t)(data[r->ubrrh.reg] & 0x0F) << 8 | data[r->ubrrl.reg];
    uint32_t clocks = *ucsra(usart) & UCSRA_U2X ? 8 : 16;
    return (ubrr + 1) * clocks * 256;
}

uint32_t usart_get_bit_time(void *context)
{
    return usart_bit_time_256(context);
}

bool usart_is_transmitting(const struct usart *usart)
{
    return (*ucsrb(usart) & UCSRB_TXEN) || usart->tx.busy || usart->udr_full || usart->queued;
}

bool usart_rxen(const struct usart *usart)
{
    return *ucsrb(usart) & UCSRB_RXEN;
}

bool usart_is_listening(const struct usart *usart)
{
    return !usart->exact || usart_rxen(usart);
}

void usart_update_txd(struct usart *usart, uint64_t now)
{
    driver_enable(&usart->txd, now, usart_is_transmitting(usart));
    usart_notify(usart, USART_ENABLED, now);
}

/* --- interrupts: levels, not edges --- */

static void update_interrupt(avr_t *avr, avr_int_vector_t *vector)
{
    cpu_set_level_interrupt(
        avr, vector, avr_regbit_get(avr, vector->raised) && avr_regbit_get(avr, vector->enable));
}

static void update_interrupts(struct usart *usart)
{
    update_interrupt(usart->avr, &usart->registers->rxc);
    update_interrupt(usart->avr, &usart->registers->udrc);
    update_interrupt(usart->avr, &usart->registers->txc);
}

/* simavr drops a request when its handler is entered. RXC and UDRE stay set until the handler has
 * served them. */
static void vector_entered(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq;
    if (!value) {
        struct usart *usart = param;
        update_interrupt(usart->avr, &usart->registers->rxc);
        update_interrupt(usart->avr, &usart->registers->udrc);
    }
}

/* --- transmitter --- */

static void start_frame(struct usart *usart, uint64_t start, uint8_t byte)
{
    uart_tx_send(&usart->tx, start, usart_bit_time_256(usart), byte);
}

static void frame_started(void *context, uint64_t now)
{
    struct usart *usart = context;
    bool good = (*ucsrc(usart) & UCSRC_FORMAT) == UCSRC_8N1 && !(*ucsrb(usart) & UCSRB_UCSZ2);
    usart_notify(usart, good ? USART_FRAME : USART_BAD_FORMAT, now);
}

static void frame_ended(void *context, uint64_t now)
{
    struct usart *usart = context;
    if (usart->udr_full) {
        usart->udr_full = false;
        *ucsra(usart) |= UCSRA_UDRE;
        start_frame(usart, now, usart->udr_byte);
    } else {
        *ucsra(usart) |= UCSRA_TXC;
        usart_update_txd(usart, now);
    }
    update_interrupts(usart);
}

static void write_udr(avr_t *avr, avr_io_addr_t address, uint8_t byte, void *param)
{
    (void)avr;
    (void)address;
    struct usart *usart = param;
    if (!(*ucsrb(usart) & UCSRB_TXEN)) {
        usart_notify(usart, USART_WRITE_OFF, write_time(usart));
    } else if (!(*ucsra(usart) & UCSRA_UDRE)) {
        usart_notify(usart, USART_WRITE_LOST, write_time(usart));
    } else if (usart->tx.busy) {
        usart->udr_full = true;
        usart->udr_byte = byte;
        *ucsra(usart) &= (uint8_t)~UCSRA_UDRE;
    } else {
        start_frame(usart, write_time(usart), byte);
    }
    update_interrupts(usart);
}

/* --- receiver --- */

static void show_received(struct usart *usart)
{
    unsigned flags = *ucsra(usart) & ~(unsigned)(UCSRA_RXC | UCSRA_FE | UCSRA_DOR);
    if (usart->fifo_size) {
        flags |= UCSRA_RXC;
        flags |= usart->fifo[0].framing_error ? UCSRA_FE : 0;
        flags |= usart->fifo[0].overrun ? UCSRA_DOR : 0;
    }
    *ucsra(usart) = (uint8_t)flags;
    update_interrupts(usart);
}

static void flush_received(struct usart *usart)
{
    usart->fifo_size = 0;
    usart->shift_full = false;
    usart->lost = false;
    show_received(usart);
}

/* The new frame overwrites the byte that waits in the shift register. */
static void start_bit_received(void *context, uint64_t now)
{
    struct usart *usart = context;
    if (usart->shift_full) {
        usart->shift_full = false;
        usart->lost = true;
        usart_notify(usart, USART_OVERRUN, now);
    }
}

static void byte_received(void *context, uint64_t now, const struct uart_frame *frame)
{
    (void)now;
    struct usart *usart = context;
    struct usart_byte received = {frame->byte, frame->framing_error, usart->lost};
    usart->lost = false;
    if (usart->fifo_size < FIFO_SIZE) {
        usart->fifo[usart->fifo_size++] = received;
        show_received(usart);
    } else {
        usart->shift = received;
        usart->shift_full = true;
    }
}

static uint8_t read_udr(avr_t *avr, avr_io_addr_t address, void *param)
{
    (void)avr;
    (void)address;
    struct usart *usart = param;
    if (usart->fifo_size) {
        usart->read = usart->fifo[0].byte;
        usart->fifo[0] = usart->fifo[1];
        usart->fifo_size--;
        if (usart->shift_full) {
            usart->shift_full = false;
            usart->fifo[usart->fifo_size++] = usart->shift;
        }
        show_received(usart);
    }
    return usart->read;
}

/* --- control registers --- */

static void write_ucsra(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    (void)avr;
    (void)address;
    struct usart *usart = param;
    unsigned flags = *ucsra(usart) & ~(unsigned)(UCSRA_U2X | UCSRA_MPCM);
    if (value & UCSRA_TXC) {
        flags &= ~(unsigned)UCSRA_TXC;
    }
    *ucsra(usart) = (uint8_t)(flags | (value & (UCSRA_U2X | UCSRA_MPCM)));
    update_interrupts(usart);
}

static void write_ucsrb(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    (void)avr;
    (void)address;
    struct usart *usart = param;
    uint8_t changed = *ucsrb(usart) ^ value;
    *ucsrb(usart) = value;
    if (changed & UCSRB_RXEN) {
        uart_rx_enable(&usart->rx, value & UCSRB_RXEN);
        flush_received(usart);
    }
    if (changed & (UCSRB_RXEN | UCSRB_TXEN)) {
        usart_update_txd(usart, write_time(usart));
    }
    update_interrupts(usart);
}

void usart_reset(struct usart *usart, uint64_t now)
{
    uart_tx_stop(&usart->tx, now);
    usart->udr_full = false;
    usart->queued = 0;
    if (usart->exact) {
        uart_rx_enable(&usart->rx, false);
        *ucsra(usart) = UCSRA_UDRE;
        *ucsrb(usart) = 0;
        *ucsrc(usart) = UCSRC_8N1;
        flush_received(usart);
    }
    usart_update_txd(usart, now);
}

static void take_register(struct usart *usart, avr_io_addr_t address, avr_io_read_t read,
                          avr_io_write_t write)
{
    usart->avr->io[AVR_DATA_TO_IO(address)].r.c = read;
    usart->avr->io[AVR_DATA_TO_IO(address)].r.param = usart;
    usart->avr->io[AVR_DATA_TO_IO(address)].w.c = write;
    usart->avr->io[AVR_DATA_TO_IO(address)].w.param = usart;
}

/* Writes to simavr's table itself: avr_register_io_read() and avr_register_io_write() refuse a
 * second callback. */
static void usart_init_exact(struct usart *usart)
{
    avr_uart_t *r = usart->registers;
    usart->tx.on_start = frame_started;
    usart->tx.on_end = frame_ended;
    usart->rx.on_start = start_bit_received;
    usart->rx.on_byte = byte_received;
    take_register(usart, r->r_udr, read_udr, write_udr);
    take_register(usart, r->r_ucsra, 0, write_ucsra);
    take_register(usart, r->r_ucsrb, 0, write_ucsrb);
    take_register(usart, r->r_ucsrc, 0, 0);
    take_register(usart, r->ubrrl.reg, 0, 0);
    take_register(usart, r->ubrrh.reg, 0, 0);
    r->rxc.raise_sticky = 1;
    r->udrc.raise_sticky = 1;
    avr_irq_register_notify(r->rxc.irq + AVR_INT_IRQ_PENDING, vector_entered, usart);
    avr_irq_register_notify(r->udrc.irq + AVR_INT_IRQ_PENDING, vector_entered, usart);
}

static avr_uart_t *find_registers(avr_t *avr, unsigned number)
{
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "uart") == 0 && ((avr_uart_t *)io)->name == (char)('0' + number)) {
            return (avr_uart_t *)io;
        }
    }
    return 0;
}

bool usart_init(struct usart *usart, avr_t *avr, unsigned number, bool exact,
                struct schedule *schedule, struct net *txd, struct net *rxd)
{
    *usart = (struct usart){.avr = avr, .exact = exact, .schedule = schedule};
    usart->registers = find_registers(avr, number);
    if (!usart->registers) {
        return false;
    }
    driver_init(&usart->txd, txd);
    uart_tx_init(&usart->tx, schedule, &usart->txd, usart);
    uart_rx_init(&usart->rx, schedule, rxd, usart);
    usart->rx.get_bit_time_256 = usart_get_bit_time;
    if (exact) {
        usart_init_exact(usart);
    } else {
        usart_init_stock(usart);
    }
    usart_reset(usart, avr->cycle);
    return true;
}
