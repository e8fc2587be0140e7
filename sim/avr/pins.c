/* SPDX-License-Identifier: MIT */
#include "avr/pins.h"

#include <string.h>

bool pin_find(struct pin *pin, avr_t *avr, char port, unsigned bit)
{
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "port") == 0 && ((avr_ioport_t *)io)->name == port && bit < 8) {
            *pin = (struct pin){.port = (avr_ioport_t *)io, .bit = (uint8_t)bit};
            return true;
        }
    }
    return false;
}

void pin_watch(const struct pin *pin, avr_irq_notify_t changed, void *context)
{
    /* This IRQ is the last one that a write raises: both registers are up to date. simavr filters
     * repeated values, which would drop the first write after a reset. */
    avr_irq_t *irq = pin->port->io.irq + IOPORT_IRQ_PIN_ALL;
    avr_irq_set_flags(irq, (uint8_t)(avr_irq_get_flags(irq) & ~IRQ_FLAG_FILTERED));
    avr_irq_register_notify(irq, changed, context);
}

enum pin_state pin_state(const struct pin *pin)
{
    const uint8_t *data = pin->port->io.avr->data;
    bool out = data[pin->port->r_ddr] >> pin->bit & 1;
    bool set = data[pin->port->r_port] >> pin->bit & 1;
    if (out) {
        return set ? PIN_HIGH : PIN_LOW;
    }
    return set ? PIN_PULLED_UP : PIN_FLOATS;
}

static uint8_t read_pins(avr_t *avr, avr_io_addr_t address, void *param)
{
    const struct pin_input *input = param;
    enum pin_state state = pin_state(&input->pin);
    uint8_t value = input->read(avr, address, input->context);
    uint8_t mask = (uint8_t)(1u << input->pin.bit);
    if (state == PIN_LOW || state == PIN_HIGH) {
        return value;
    }
    return (uint8_t)(input->net->level ? value | mask : value & ~mask);
}

/* Does not use simavr's pin IRQ: simavr's INTn module would poll the pin in each cycle while it is
 * low. */
void pin_connect_input(struct pin_input *input, const struct pin *pin, const struct net *net)
{
    avr_t *avr = pin->port->io.avr;
    __typeof__(avr->io[0]) *io = &avr->io[AVR_DATA_TO_IO(pin->port->r_pin)];
    *input = (struct pin_input){.pin = *pin, .net = net, .read = io->r.c, .context = io->r.param};
    io->r.c = read_pins;
    io->r.param = input;
}
