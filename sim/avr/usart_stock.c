/* SPDX-License-Identifier: MIT */
/* simavr's own USART, connected to the nets byte by byte: the common way to use simavr. */
#include "avr/usart.h"

#include <string.h>

static void send_next(struct usart *usart, uint64_t start)
{
    uint8_t byte = usart->queue[0];
    usart->queued--;
    memmove(usart->queue, usart->queue + 1, usart->queued);
    uart_tx_send(&usart->tx, start, usart_bit_time_256(usart), byte);
}

static void frame_started(void *context, uint64_t now)
{
    usart_notify(context, USART_FRAME, now);
}

static void frame_ended(void *context, uint64_t now)
{
    struct usart *usart = context;
    if (usart->queued) {
        send_next(usart, now);
    } else {
        usart_update_txd(usart, now);
    }
}

static void byte_written(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq;
    struct usart *usart = param;
    uint64_t now = usart->avr->cycle + USART_WRITE_CYCLES;
    if (usart->queued == USART_QUEUE) {
        usart_notify(usart, USART_WRITE_LOST, now);
        return;
    }
    usart->queue[usart->queued++] = (uint8_t)value;
    if (!usart->tx.busy) {
        send_next(usart, now);
    }
}

static void byte_received(void *context, uint64_t now, const struct uart_frame *frame)
{
    struct usart *usart = context;
    if (!avr_regbit_get(usart->avr, usart->registers->rxen)) {
        usart_notify(usart, USART_BYTE_IGNORED, now);
    }
    uint32_t value = frame->byte | (frame->framing_error ? UART_INPUT_FE : 0u);
    avr_raise_irq(usart->registers->io.irq + UART_IRQ_INPUT, value);
}

static void write_udr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct usart *usart = param;
    usart->stock_write_udr(avr, address, value, usart->stock_udr);
    if (!avr_regbit_get(avr, usart->registers->txen)) {
        usart_notify(usart, USART_WRITE_OFF, avr->cycle + USART_WRITE_CYCLES);
    }
}

static void write_ucsrb(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct usart *usart = param;
    usart->stock_write_ucsrb(avr, address, value, usart->stock_ucsrb);
    usart_update_txd(usart, avr->cycle + USART_WRITE_CYCLES);
}

void usart_init_stock(struct usart *usart)
{
    avr_uart_t *r = usart->registers;
    usart->tx.on_start = frame_started;
    usart->tx.on_end = frame_ended;
    usart->rx.on_byte = byte_received;
    uart_rx_enable(&usart->rx, true);

    uint32_t no_flags =
        0; // no echo on stdout, and no sleep of the host when the firmware polls UCSRA
    avr_ioctl(usart->avr, (uint32_t)AVR_IOCTL_UART_SET_FLAGS(r->name), &no_flags);
    avr_irq_register_notify(r->io.irq + UART_IRQ_OUTPUT, byte_written, usart);

    __typeof__(usart->avr->io[0]) *udr = &usart->avr->io[AVR_DATA_TO_IO(r->r_udr)];
    usart->stock_write_udr = udr->w.c;
    usart->stock_udr = udr->w.param;
    udr->w.c = write_udr;
    udr->w.param = usart;
    __typeof__(usart->avr->io[0]) *ucsrb = &usart->avr->io[AVR_DATA_TO_IO(r->r_ucsrb)];
    usart->stock_write_ucsrb = ucsrb->w.c;
    usart->stock_ucsrb = ucsrb->w.param;
    ucsrb->w.c = write_ucsrb;
    ucsrb->w.param = usart;
}
